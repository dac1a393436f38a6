//! The Mann-Whitney U test (Mann and Whitney, On a test of whether one of two random variables is stochastically larger
//! than the other, 1947).

/// Values in both groups together up to which the distribution of U is counted out.
const EXACT: usize = 100;

/// What a Mann-Whitney U test came to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MannWhitney {
    /// U of the first group: the pairs in which its value is the greater one, ties counting half.
    pub u: f64,
    /// Two-tailed p-value.
    pub p: f64,
    /// Effect size: the share of those pairs (Vargha and Delaney's A12, 2000); 0.5 where neither group tends to be
    /// greater.
    pub a12: f64,
}

/// Whether the values of one group tend to be greater than those of another. None if a group is empty or holds a value
/// that is not a number.
///
/// Equal values share the mean of their ranks. Up to 100 values together, p is exact: twice the smaller tail, at most
/// 1, of U's distribution over all ways to deal these very values, ties and all, to both groups. Beyond, it is that of
/// the normal approximation, corrected for ties and continuity.
///
/// ```
/// use selftalk::statistics::mann_whitney;
///
/// let test = mann_whitney(&[40.0, 39.0, 40.0, 38.0], &[12.0, 20.0, 31.0, 38.0]).unwrap();
/// assert_eq!((test.u, test.a12), (15.5, 15.5 / 16.0));
/// assert!(test.p < 0.06);
/// ```
#[must_use]
pub fn mann_whitney(a: &[f64], b: &[f64]) -> Option<MannWhitney> {
    if a.is_empty() || b.is_empty() || a.iter().chain(b).any(|value| value.is_nan()) {
        return None;
    }
    let Ranks { doubled, ties } = Ranks::new(a, b);
    let own: u64 = doubled[..a.len()].iter().sum();
    let (n, m) = (a.len() as f64, b.len() as f64);
    let u = own as f64 / 2.0 - n * (n + 1.0) / 2.0;
    let p = if doubled.len() <= EXACT { exact(&doubled, a.len(), own) } else { approximate(u, n, m, ties) };
    Some(MannWhitney { u, p, a12: u / (n * m) })
}

/// Twice the ranks of all values, the first group's first, and the sum of t³ - t over all sets of t equal values.
struct Ranks {
    doubled: Vec<u64>,
    ties: f64,
}

impl Ranks {
    fn new(a: &[f64], b: &[f64]) -> Self {
        let values: Vec<f64> = a.iter().chain(b).copied().collect();
        let mut order: Vec<usize> = (0..values.len()).collect();
        order.sort_by(|i, j| values[*i].total_cmp(&values[*j]));
        let (mut doubled, mut ties) = (vec![0; values.len()], 0.0);
        let mut before = 0;
        for equal in order.chunk_by(|i, j| values[*i] == values[*j]) {
            let count = equal.len();
            for index in equal {
                doubled[*index] = (2 * before + count + 1) as u64;
            }
            let t = count as f64;
            ties += t * t * t - t;
            before += count;
        }
        Self { doubled, ties }
    }
}

/// Twice the smaller tail of the sum of `size` ranks, at `sum`, over all choices of as many.
fn exact(ranks: &[u64], size: usize, sum: u64) -> f64 {
    let total = ranks.iter().sum::<u64>() as usize;
    // Choices of so many of the ranks seen so far that come to each sum. Exact up to 2^53; beyond, the relative error
    // stays below the number of ranks times that of one addition.
    let mut choices = vec![vec![0.0_f64; total + 1]; size + 1];
    choices[0][0] = 1.0;
    for rank in ranks.iter().map(|rank| *rank as usize) {
        for count in (1..=size).rev() {
            let (fewer, more) = choices.split_at_mut(count);
            let fewer = &fewer[count - 1];
            for (with, without) in more[0][rank..].iter_mut().zip(fewer) {
                *with += *without;
            }
        }
    }
    let choices = &choices[size];
    let at = sum as usize;
    let all: f64 = choices.iter().sum();
    let tail = choices[..=at].iter().sum::<f64>().min(choices[at..].iter().sum());
    (2.0 * tail / all).min(1.0)
}

fn approximate(u: f64, n: f64, m: f64, ties: f64) -> f64 {
    let all = n + m;
    let variance = n * m / 12.0 * (all + 1.0 - ties / (all * (all - 1.0)));
    if variance <= 0.0 {
        return 1.0;
    }
    let distance = ((u - n * m / 2.0).abs() - 0.5).max(0.0);
    libm::erfc(distance / (2.0 * variance).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Cases and results of SciPy, and how they were made.
    const SCIPY: &str = include_str!("../../referee/mann_whitney.csv");

    #[test]
    fn scipy_comes_to_the_same() {
        let numbers =
            |text: &str| text.split(' ').map(|number| number.parse().unwrap()).collect::<Vec<f64>>();
        let mut cases = 0;
        for record in csv::Reader::from_reader(SCIPY.as_bytes()).records() {
            let record = record.unwrap();
            let found = mann_whitney(&numbers(&record[1]), &numbers(&record[2])).unwrap();
            let (u, p): (f64, f64) = (record[3].parse().unwrap(), record[4].parse().unwrap());
            assert_eq!(found.u, u, "{record:?}");
            assert!((found.p - p).abs() < 1e-12 + 1e-9 * p, "{found:?}: {record:?}");
            cases += 1;
        }
        assert!(cases > 30, "{cases}");
    }

    #[test]
    fn groups_apart_differ_as_clearly_as_their_size_allows() {
        let found = mann_whitney(&[4.0, 5.0, 6.0], &[1.0, 2.0, 3.0]).unwrap();
        assert_eq!(found, MannWhitney { u: 9.0, p: 0.1, a12: 1.0 });
    }

    #[test]
    fn nothing_can_be_said_of_nothing() {
        assert_eq!(mann_whitney(&[], &[1.0]), None);
        assert_eq!(mann_whitney(&[1.0], &[f64::NAN]), None);
    }

    #[test]
    fn the_approximation_takes_over_smoothly() {
        let group = |size: u32, step: f64| (0..size).map(|i| f64::from(i % 17) * step).collect::<Vec<_>>();
        let [below, above] = [50, 51].map(|size| mann_whitney(&group(size, 1.0), &group(50, 1.2)).unwrap().p);
        assert!((below - above).abs() < 0.05, "{below} {above}");
        let equal = vec![1.0; 70];
        assert_eq!(mann_whitney(&equal, &equal).unwrap().p, 1.0);
    }

    fn group() -> impl Strategy<Value = Vec<f64>> {
        prop::collection::vec((0..8_u32).prop_map(f64::from), 1..12)
    }

    proptest! {
        #[test]
        fn the_groups_change_places(a in group(), b in group()) {
            let (one, other) = (mann_whitney(&a, &b).unwrap(), mann_whitney(&b, &a).unwrap());
            prop_assert_eq!(one.u + other.u, (a.len() * b.len()) as f64);
            prop_assert!((one.p - other.p).abs() < 1e-12);
            prop_assert!((one.a12 + other.a12 - 1.0).abs() < 1e-12);
            prop_assert!(one.p > 0.0 && one.p <= 1.0);
        }

        #[test]
        fn only_the_order_of_the_values_counts(a in group(), b in group()) {
            let stretched = |values: &[f64]| values.iter().map(|value| value * value + 3.0).collect::<Vec<_>>();
            prop_assert_eq!(mann_whitney(&a, &b), mann_whitney(&stretched(&a), &stretched(&b)));
        }
    }
}
