//! The camera of a scene.

use super::fields::setting::{choices, settings};

settings! {
    /// The camera.
    pub struct Camera: CameraField = "camera." {
        /// Projection of the rays.
        projection: Projection = Projection::Perspective => Picture, Kind::Choice(Projection::CHOICES), flag("projection");
        /// Degrees around the vertical axis: 0 looks at the +z side, 90 at the +x side.
        azimuth: f32 = 30.0 => View, number(-1e6, 1e6), usual(-180.0, 180.0), unit(Unit::Degrees);
        /// Degrees above the horizon.
        elevation: f32 = 25.0 => View, number(-90.0, 90.0), unit(Unit::Degrees);
        /// Rotation from object space to camera space, a unit quaternion x, y, z, w; replaces azimuth and elevation.
        rotation: Option<[f32; 4]> = None => View, numbers(4, -10.0, 10.0), optional("[0, 0, 0, 1]");
        /// Shift of the picture to the right and up, object units at the middle of the scene.
        pan: [f32; 2] = [0.0; 2] => View, numbers(2, -100.0, 100.0), usual(-2.0, 2.0), unit(Unit::ObjectUnits);
        /// 1 fits the object into the picture; 2 is twice as close.
        zoom: f32 = 1.0 => View, number(0.01, 100.0), usual(0.1, 30.0);
        /// Vertical angle of view in degrees, for perspective only.
        field_of_view: f32 = 30.0 => View, number(1.0, 120.0), unit(Unit::Degrees);
        /// Time in seconds.
        time: f64 = 0.0 => View, number(-1e9, 1e9), usual(0.0, 60.0), flag("time"), unit(Unit::Seconds);
        /// Seconds that the shutter stays open; needs quality.supersampling of 2 or more.
        shutter: f32 = 0.0 => View, number(0.0, 1e6), usual(0.0, 1.0), flag("shutter"), unit(Unit::Seconds);
        /// Clip plane a, b, c, d: keeps the points x, y, z of object space with a x + b y + c z <= d; the object spans -1 to 1.
        clip: Option<[f32; 4]> = None
            => Picture, numbers(4, -1e6, 1e6), usual(-2.0, 2.0), optional("[0, 0, 1, 0]"), flag("clip");
        /// Shows the stack of slices from the side (MJ Fig. 1); classify = stack draws it.
        slice_stack: bool = false => Targets, Kind::Switch;
        /// A view matrix from object space to camera space and a projection matrix, column by column; they replace rotation, pan, zoom and angle of view.
        matrices: Option<[f32; 32]> = None
            => Picture, Kind::Numbers(32, Range::ANY),
            optional("[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -5, 1, 3, 0, 0, 0, 0, 3, 0, 0, 0, 0, 0, -1, 0, 0, 0.1, 0]");
    }
}

choices! {
    /// Projection of the rays.
    pub enum Projection {
        /// Rays leave from one point.
        #[default]
        Perspective = "perspective",
        /// Rays are parallel.
        Parallel = "parallel",
    }
}

impl Camera {
    /// Rotation from object space to camera space: `rotation`, or `azimuth` about the vertical axis and then `elevation`.
    pub fn turn(&self) -> glam::Quat {
        match self.rotation {
            Some(rotation) => glam::Quat::from_array(rotation).normalize(),
            None => {
                let elevation = glam::Quat::from_rotation_x(self.elevation.to_radians());
                elevation * glam::Quat::from_rotation_y(-(self.azimuth % 360.0).to_radians())
            }
        }
    }
}
