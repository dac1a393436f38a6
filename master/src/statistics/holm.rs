//! Correction for several tests (Holm, A simple sequentially rejective multiple test procedure, 1979).

/// The p-values of a family of tests, corrected, in their order: the smallest is multiplied by their number, the next
/// by one less, and so on; none becomes smaller than the one before it, or greater than 1.
///
/// ```
/// assert_eq!(selftalk::statistics::holm(&[0.25, 0.125, 0.5]), [0.5, 0.375, 0.5]);
/// ```
#[must_use]
pub fn holm(p: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..p.len()).collect();
    order.sort_by(|a, b| p[*a].total_cmp(&p[*b]));
    let mut corrected = vec![0.0; p.len()];
    let mut least: f64 = 0.0;
    for (place, index) in order.into_iter().enumerate() {
        least = least.max(p[index] * (p.len() - place) as f64).min(1.0);
        corrected[index] = least;
    }
    corrected
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_is_multiplied_by_the_number_of_those_not_smaller() {
        assert!(holm(&[]).is_empty());
        assert_eq!(holm(&[0.25]), [0.25]);
        assert_eq!(holm(&[0.25, 0.03125, 0.0625]), [0.25, 0.09375, 0.125]);
    }

    #[test]
    fn the_order_stays_and_one_is_the_most() {
        assert_eq!(holm(&[0.25, 0.1875, 0.75]), [0.5625, 0.5625, 0.75]);
        assert_eq!(holm(&[0.5, 0.5, 0.5]), [1.0, 1.0, 1.0]);
    }
}
