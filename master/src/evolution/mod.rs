//! Population, selection and reproduction: pure functions.
