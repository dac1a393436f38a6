//! What a box of a boxplot shows.

/// A boxplot's numbers (Tukey, Exploratory Data Analysis, 1977).
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FiveNumbers {
    /// Smallest value that is no outlier, lower quartile, median, upper quartile, greatest value that is no outlier.
    pub(super) numbers: [f64; 5],
    /// Values more than 1.5 times the distance of the quartiles beyond them, ascending.
    pub(super) outliers: Vec<f64>,
}

/// The numbers of some values; none of nothing. Quartiles are interpolated linearly between the values.
pub(super) fn five_numbers(values: &[f64]) -> Option<FiveNumbers> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().checked_sub(1)?;
    let quantile = |share: f64| {
        let place = share * last as f64;
        let below = (place.floor() as usize).min(last);
        let above = (below + 1).min(last);
        sorted[below] + (place - below as f64) * (sorted[above] - sorted[below])
    };
    let [lower, middle, upper] = [0.25, 0.5, 0.75].map(quantile);
    let reach = 1.5 * (upper - lower);
    let (inner, outliers): (Vec<f64>, Vec<f64>) =
        sorted.iter().partition(|value| (lower - reach..=upper + reach).contains(*value));
    let (first, last) = (*inner.first()?, *inner.last()?);
    Some(FiveNumbers { numbers: [first, lower, middle, upper, last], outliers })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quartiles_are_interpolated_and_far_values_are_outliers() {
        assert_eq!(five_numbers(&[]), None);
        let one = five_numbers(&[3.0]).unwrap();
        assert_eq!((one.numbers, one.outliers.len()), ([3.0; 5], 0));
        let four = five_numbers(&[4.0, 1.0, 3.0, 2.0]).unwrap();
        assert_eq!(four.numbers, [1.0, 1.75, 2.5, 3.25, 4.0]);
        let far = five_numbers(&[10.0, 11.0, 12.0, 13.0, 14.0, 90.0]).unwrap();
        assert_eq!((far.numbers[0], far.numbers[4]), (10.0, 14.0));
        assert_eq!(far.outliers, [90.0]);
    }
}
