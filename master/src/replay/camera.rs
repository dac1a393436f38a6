//! The camera that the page starts with.

use nalgebra::Vector3;

/// What it looks at.
const FOCUS: [f64; 3] = [-0.27, -0.06, 0.08];
/// From where: angle around the vertical, angle above the horizontal, and distance.
const YAW: f64 = -2.2;
const PITCH: f64 = 0.42;
const DISTANCE: f64 = 1.15;
/// Pixels for a metre at a metre's distance, of a picture one pixel high: nearer than the page, which can be zoomed.
const ZOOM: f64 = 1.6;

/// A camera for a picture of some size.
#[derive(Debug, Clone, Copy)]
pub(super) struct Camera {
    size: [f64; 2],
    right: Vector3<f64>,
    up: Vector3<f64>,
    back: Vector3<f64>,
}

/// Where a point is in the picture.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seen {
    pub(super) x: f64,
    pub(super) y: f64,
    /// Its distance along the camera's axis, m.
    pub(super) depth: f64,
    /// Pixels for a metre there.
    pub(super) scale: f64,
}

impl Camera {
    pub(super) fn new(size: [f64; 2]) -> Self {
        let (cy, sy, cp, sp) = (libm::cos(YAW), libm::sin(YAW), libm::cos(PITCH), libm::sin(PITCH));
        Self {
            size,
            right: Vector3::new(-sy, cy, 0.0),
            up: Vector3::new(-cy * sp, -sy * sp, cp),
            back: Vector3::new(cy * cp, sy * cp, sp),
        }
    }

    pub(super) fn see(&self, point: [f64; 3]) -> Seen {
        let from_focus = Vector3::from(point) - Vector3::from(FOCUS);
        let depth = DISTANCE - from_focus.dot(&self.back);
        let [width, height] = self.size;
        let scale = ZOOM * width.min(height) / depth.max(0.05);
        let (x, y) = (scale * from_focus.dot(&self.right), scale * from_focus.dot(&self.up));
        Seen { x: width / 2.0 + x, y: height / 2.0 - y, depth, scale }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn up_is_up_and_what_is_nearer_is_larger() {
        let camera = Camera::new([300.0, 200.0]);
        let focus = camera.see(FOCUS);
        assert_eq!((focus.x, focus.y), (150.0, 100.0));
        let [x, y, z] = FOCUS;
        assert!(camera.see([x, y, z + 0.1]).y < 100.0);
        // The robot's left is at negative y, and the camera is in front of it.
        let [left, right] = [-0.2, 0.2].map(|side| camera.see([x, y + side, z]));
        assert!(left.scale > right.scale && left.depth < right.depth);
    }

    #[test]
    fn the_page_has_the_same_camera() {
        let page = include_str!("replay.html");
        assert!(page.contains(&format!("START = {{ yaw: {YAW}, pitch: {PITCH}, distance: {DISTANCE} }}")));
        let [x, y, z] = FOCUS;
        assert!(page.contains(&format!("FOCUS = [{x}, {y}, {z}]")));
    }
}
