//! The genotype: a string of 16-bit genes.

use std::fmt;

use sha2::{Digest, Sha256};
use thiserror::Error;

/// Bits in a gene (paper, section II.C).
pub const GENE_BITS: u32 = 16;

/// A string of 16-bit genes, each a parameter of the controller.
#[derive(Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Genotype(Box<[u16]>);

/// Why bytes are not a genotype.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum GenotypeError {
    /// The byte string has another length than the controller's genes need.
    #[error("a genotype of {expected} genes takes {} bytes, not {found}", expected * 2)]
    Length {
        /// Genes the controller has.
        expected: usize,
        /// Bytes that were given.
        found: usize,
    },
    /// The text is not four hexadecimal digits a gene.
    #[error("genes are written with four hexadecimal digits each")]
    Digits,
    /// A bit position lies behind the last gene.
    #[error("bit {bit} lies outside a genotype of {bits} bits")]
    Bit {
        /// The position that was asked for.
        bit: u32,
        /// Bits the genotype has.
        bits: u32,
    },
}

impl Genotype {
    /// A genotype of the given genes.
    #[must_use]
    pub fn new(genes: impl Into<Box<[u16]>>) -> Self {
        Self(genes.into())
    }

    /// Reads `genes` genes, little-endian.
    ///
    /// # Errors
    /// [`GenotypeError::Length`] when `bytes` is not two bytes a gene.
    pub fn from_bytes(bytes: &[u8], genes: usize) -> Result<Self, GenotypeError> {
        let (pairs, rest) = bytes.as_chunks::<2>();
        if pairs.len() != genes || !rest.is_empty() {
            return Err(GenotypeError::Length { expected: genes, found: bytes.len() });
        }
        Ok(Self(pairs.iter().map(|pair| u16::from_le_bytes(*pair)).collect()))
    }

    /// The genes, little-endian, two bytes each.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = vec![0; 2 * self.0.len()];
        for (pair, gene) in bytes.as_chunks_mut::<2>().0.iter_mut().zip(&self.0) {
            *pair = gene.to_le_bytes();
        }
        bytes
    }

    /// Reads genes of four hexadecimal digits each.
    ///
    /// # Errors
    /// [`GenotypeError::Digits`] when the text has anything else.
    pub fn from_hex(text: &str) -> Result<Self, GenotypeError> {
        let (genes, rest) = text.as_bytes().as_chunks::<4>();
        let digit = |digit: u8| char::from(digit).to_digit(16);
        let gene =
            |digits: &[u8; 4]| digits.iter().try_fold(0, |gene, at| Some(gene << 4 | digit(*at)? as u16));
        let genes = genes.iter().map(gene).collect::<Option<Box<[u16]>>>().filter(|_| rest.is_empty());
        genes.map(Self).ok_or(GenotypeError::Digits)
    }

    /// The genes, four hexadecimal digits each.
    #[must_use]
    pub fn to_hex(&self) -> String {
        self.0.iter().map(|gene| format!("{gene:04x}")).collect()
    }

    /// The genes in the controller's order.
    #[must_use]
    pub fn genes(&self) -> &[u16] {
        &self.0
    }

    /// Length in bits.
    #[must_use]
    pub fn bits(&self) -> u32 {
        self.0.len() as u32 * GENE_BITS
    }

    /// A copy in which the given bits are flipped; bit `b` is bit `b % 16`, counted from the least significant,
    /// of gene `b / 16`.
    ///
    /// # Errors
    /// [`GenotypeError::Bit`] when a position lies outside the genotype.
    pub fn with_flipped(&self, bits: &[u32]) -> Result<Self, GenotypeError> {
        let mut copy = self.clone();
        for &bit in bits {
            let gene = copy
                .0
                .get_mut((bit / GENE_BITS) as usize)
                .ok_or(GenotypeError::Bit { bit, bits: self.bits() })?;
            *gene ^= 1 << (bit % GENE_BITS);
        }
        Ok(copy)
    }

    /// SHA-256 of the genes' bytes.
    fn sha256(&self) -> [u8; 32] {
        Sha256::digest(self.to_bytes()).into()
    }
}

impl fmt::Debug for Genotype {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let hash = self.sha256();
        write!(f, "Genotype({} genes, {:02x}{:02x}{:02x}…)", self.0.len(), hash[0], hash[1], hash[2])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn bytes_and_digits_round_trip(genes in prop::collection::vec(any::<u16>(), 0..50)) {
            let genotype = Genotype::new(genes.clone());
            prop_assert_eq!(Genotype::from_hex(&genotype.to_hex()), Ok(genotype.clone()));
            prop_assert_eq!(Genotype::from_bytes(&genotype.to_bytes(), genes.len()), Ok(genotype));
        }

        #[test]
        fn flipping_twice_restores(genes in prop::collection::vec(any::<u16>(), 1..50), bit in 0_u32..800) {
            let genotype = Genotype::new(genes);
            let bit = bit % genotype.bits();
            let flipped = genotype.with_flipped(&[bit])?;
            let differing: u32 =
                genotype.genes().iter().zip(flipped.genes()).map(|(a, b)| (a ^ b).count_ones()).sum();
            prop_assert_eq!(differing, 1);
            prop_assert_eq!(flipped.with_flipped(&[bit])?, genotype);
        }
    }

    #[test]
    fn wrong_lengths_digits_and_positions_are_refused() {
        assert_eq!(Genotype::new([0x00ff, 0x1234]).to_hex(), "00ff1234");
        for text in ["00ff123", "00fg", "+123"] {
            assert_eq!(Genotype::from_hex(text), Err(GenotypeError::Digits));
        }
        assert_eq!(Genotype::from_bytes(&[0; 5], 2), Err(GenotypeError::Length { expected: 2, found: 5 }));
        assert_eq!(
            Genotype::new([0_u16; 2]).with_flipped(&[32]),
            Err(GenotypeError::Bit { bit: 32, bits: 32 })
        );
    }
}
