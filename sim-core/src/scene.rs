//! Table, object and target (paper, section II.A). Root frame, metres and kilograms.

/// Height of the table top; the table is a half-space, wider than the arm can reach.
pub const TABLE: f64 = -0.02;
/// Gravity, m/s^2.
pub const GRAVITY: f64 = 9.81;

/// The object is a ball of this radius ...
pub const OBJECT_RADIUS: f64 = 0.035;
/// ... cut flat this far below its centre.
pub const OBJECT_BASE: f64 = 0.032;
/// Mass of the object.
pub const OBJECT_MASS: f64 = 0.2;
/// Rotational inertia of the object in all directions, kg m^2: the whole ball's, with its centre as centre of mass
/// (what is cut off weighs less than 1 % of it).
pub const OBJECT_INERTIA: f64 = 0.4 * OBJECT_MASS * OBJECT_RADIUS * OBJECT_RADIUS;
/// Height of the object's centre while it stands on the table.
pub const OBJECT_STANDING: f64 = TABLE + OBJECT_BASE;

/// The middle of the four areas in which the object is placed: in front of the robot, to its left. The initial
/// postures belong to these areas.
pub const AREAS_CENTRE: [f64; 2] = [-0.30, -0.10];
/// Distance of the areas' centres from their middle.
pub const AREAS_DISTANCE: f64 = 0.10;
/// Directions of the areas' centres from their middle: to the front, back, left and right.
pub const AREA_DIRECTIONS: [[f64; 2]; 4] = [[-1.0, 0.0], [1.0, 0.0], [0.0, -1.0], [0.0, 1.0]];
/// Directions of the two target areas along y: left and right.
pub const TARGET_DIRECTIONS: [f64; 2] = [-1.0, 1.0];
