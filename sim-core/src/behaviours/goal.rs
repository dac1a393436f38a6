//! What a goal asks for: values that are measured in a state, and their bounds.

/// What a part of a goal measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Quantity {
    /// Distance from the palm to the top of the object, m.
    PalmToTop,
    /// Extension of the fingers: 1 minus their mean flexion, as shares of their ranges.
    Extension,
    /// Cosine of the angle between the palm's outward normal and straight down.
    Alignment,
    /// Distance from the centroid of thumb tip, little finger tip and palm to the object's centre, m.
    GripToObject,
    /// Touch sensors that feel the object.
    Touches,
    /// Height of the object's base above the table, m.
    Height,
    /// Distance from the object's centre to the target, m.
    ObjectToTarget,
}

impl Quantity {
    /// All quantities.
    pub const ALL: [Self; 7] = [
        Self::PalmToTop,
        Self::Extension,
        Self::Alignment,
        Self::GripToObject,
        Self::Touches,
        Self::ObjectToTarget,
        Self::Height,
    ];

    /// Lower-case name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::PalmToTop => "palm to top",
            Self::Extension => "extension",
            Self::Alignment => "alignment",
            Self::GripToObject => "grip to object",
            Self::Touches => "touches",
            Self::Height => "height",
            Self::ObjectToTarget => "object to target",
        }
    }
}

/// The values with which a condition holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bound {
    /// Smaller ones.
    Below(f64),
    /// Greater ones.
    Above(f64),
    /// This one and greater ones.
    AtLeast(f64),
}

/// A part of a behaviour's goal, as it is in a state. The state is the goal when all of them hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Condition {
    /// What is measured.
    pub quantity: Quantity,
    /// What it is.
    pub value: f64,
    /// What it should be.
    pub bound: Bound,
}

impl Condition {
    pub(super) const fn below(quantity: Quantity, value: f64, bound: f64) -> Self {
        Self { quantity, value, bound: Bound::Below(bound) }
    }

    pub(super) const fn above(quantity: Quantity, value: f64, bound: f64) -> Self {
        Self { quantity, value, bound: Bound::Above(bound) }
    }

    pub(super) const fn at_least(quantity: Quantity, value: f64, bound: f64) -> Self {
        Self { quantity, value, bound: Bound::AtLeast(bound) }
    }

    /// Whether the value is as it should be; what is not a number never is.
    #[must_use]
    pub fn holds(&self) -> bool {
        match self.bound {
            Bound::Below(bound) => self.value < bound,
            Bound::Above(bound) => self.value > bound,
            Bound::AtLeast(bound) => self.value >= bound,
        }
    }

    /// How far the value is on the wrong side of its bound; 0 or less on the right one.
    #[must_use]
    pub fn shortfall(&self) -> f64 {
        match self.bound {
            Bound::Below(bound) => self.value - bound,
            Bound::Above(bound) | Bound::AtLeast(bound) => bound - self.value,
        }
    }
}

/// Whether all conditions hold.
pub(super) fn reached(conditions: &[Condition]) -> bool {
    conditions.iter().all(Condition::holds)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_strict_unless_they_say_otherwise() {
        let quantity = Quantity::Touches;
        for (bound, expected) in [
            (Bound::Below(1.0), [true, false, false]),
            (Bound::Above(1.0), [false, false, true]),
            (Bound::AtLeast(1.0), [false, true, true]),
        ] {
            let found = [0.5, 1.0, 1.5].map(|value| Condition { quantity, value, bound }.holds());
            assert_eq!(found, expected, "{bound:?}");
            let condition = Condition { quantity, value: f64::NAN, bound };
            assert!(!condition.holds());
        }
        assert_eq!(Condition::above(quantity, 0.5, 0.75).shortfall(), 0.25);
        assert_eq!(Condition::below(quantity, 0.5, 0.75).shortfall(), -0.25);
    }
}
