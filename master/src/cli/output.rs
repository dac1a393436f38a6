//! Data for people and for programs: one table, three formats.
