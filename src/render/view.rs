//! Where eye, object and slices are: the matrices of a scene.
//!
//! Eye space: the eye at the origin, looking along -z, y up; one unit is one object unit. The slices live there, and the
//! rotation of the object reaches them through the texture matrix alone (MJ 3.3).

use super::Subject;
use crate::glsl::link::MAIN;
use crate::pass::Extent;
use crate::scene::{Knobs, Place, Projection, Scene};
use crate::variant::Variant;
use glam::camera::rh;
use glam::{Mat4, Vec3};

/// The object fills this part of the height of a picture at zoom 1, whatever grows around it. Larger: hair is cut off.
const FILL: f32 = 0.8;
/// Nothing nearer to the eye than this is drawn, object units. Smaller: the perspective division loses its digits.
const NEAR: f32 = 1e-3;
/// How far the stack of slices is turned to be looked at from the side, degrees: MJ Fig. 1.
const STACK_TURN: f32 = 62.0;

/// The matrices of a scene.
pub(super) struct View {
    pub(super) projection: Mat4,
    pub(super) object_matrix: Mat4,
    pub(super) texture_matrix: Mat4,
    pub(super) display_matrix: Mat4,
    pub(super) light_eye: Vec3,
    /// The scene's own object, then the further ones.
    pub(super) objects: Vec<Own>,
    pub(super) box_min: Vec3,
    pub(super) box_max: Vec3,
    /// No matter is farther from the origin of object space than this.
    pub(super) soft_radius: f32,
    pub(super) extent: Extent,
    /// Half width and height of the view: at depth 1 in perspective, at any depth in parallel projection.
    pub(super) ray_scale: [f32; 2],
    /// How far the picture is moved to the right and down; its sides are at -1 and 1.
    pub(super) pan: [f32; 2],
    slice_stack: bool,
}

/// What each object has for itself.
pub(super) struct Own {
    /// Its name in the scene; empty for the scene's own.
    pub(super) name: String,
    /// From its own space to object space of the scene.
    pub(super) place: Mat4,
    /// Units of the scene in one of its own.
    pub(super) scale: f32,
    /// Signed distance at which the soft region starts, its own units.
    pub(super) outer_iso: f32,
    /// Box around the soft region, its own space.
    pub(super) own_min: Vec3,
    pub(super) own_max: Vec3,
    /// No matter is farther from the origin of its own space than this.
    pub(super) own_radius: f32,
    /// The sphere around the object alone: its center and its radius, object space of the scene.
    center: Vec3,
    radius: f32,
}

impl Own {
    fn of(name: &str, place: Place, scene: &Scene, subject: &Subject, knobs: &Knobs) -> Own {
        // Of the scene, not of the program: pre-classification softens the voxels, and its program does not.
        let soft = scene.effect.softness != "hard";
        let declared = knobs.outer_iso().unwrap_or(scene.object.outer_iso);
        let outer_iso = if soft { declared } else { scene.object.inner_iso };
        let reach = outer_iso.max(0.0) + knobs.reach();
        // The radius is that of the samples inside: the surface is at most a voxel beyond. And a rounding.
        let voxel = subject.field.as_ref().map_or(0.0, |field| field.grid.spacing.length() * subject.scale);
        Own {
            name: name.into(),
            place: place.matrix(),
            scale: place.scale,
            outer_iso,
            own_min: -subject.half_size - reach,
            own_max: subject.half_size + reach,
            own_radius: 1.0001 * (subject.radius + voxel + reach),
            center: Vec3::from(place.at),
            radius: place.scale * subject.radius,
        }
    }

    /// Corners of the box around the soft region, object space of the scene.
    fn corners(&self) -> impl Iterator<Item = Vec3> + '_ {
        (0..8).map(|corner| {
            let pick = |axis: usize| if corner >> axis & 1 == 1 { self.own_max[axis] } else { self.own_min[axis] };
            self.place.transform_point3(Vec3::new(pick(0), pick(1), pick(2)))
        })
    }
}

/// The box around the soft region of the whole, object space of the scene.
fn soft_box(scene: &Scene, objects: &[Own]) -> (Vec3, Vec3) {
    let all = || objects.iter().flat_map(Own::corners);
    let around = |corners: &mut dyn Iterator<Item = Vec3>| {
        corners.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), corner| (low.min(corner), high.max(corner)))
    };
    let of = |name: &str| {
        let own = objects.iter().find(|own| own.name == name || (own.name.is_empty() && name == MAIN));
        own.map_or_else(|| around(&mut all()), |own| around(&mut own.corners()))
    };
    let both = |a: (Vec3, Vec3), b: (Vec3, Vec3)| {
        let (low, high) = (a.0.max(b.0), a.1.min(b.1));
        if low.cmplt(high).all() { (low, high) } else { a } // objects that are apart: nothing is there to be seen
    };
    let either = |a: (Vec3, Vec3), b: (Vec3, Vec3)| (a.0.min(b.0), a.1.max(b.1));
    let whole = scene.formula().ok().and_then(|formula| formula.bound(&of, &both, &either));
    whole.unwrap_or_else(|| around(&mut all()))
}

/// Half the height of the view at the depth of the middle of the scene, object units: what [`crate::scene::Camera::pan`]
/// is measured by.
pub fn half_height(scene: &Scene, subject: &Subject, variant: &Variant) -> f32 {
    let view = View::of(scene, subject, variant);
    match scene.camera.projection {
        Projection::Perspective => view.ray_scale[1] * view.extent.distance,
        Projection::Parallel => view.ray_scale[1],
    }
}

impl View {
    pub(super) fn of(scene: &Scene, subject: &Subject, variant: &Variant) -> View {
        let camera = &scene.camera;
        let mut objects = vec![Own::of("", Place::default(), scene, subject, &variant.knobs)];
        for (name, part) in &scene.parts {
            objects.push(Own::of(name, part.place, &scene.alone(name), &subject.parts[name], &variant.parts[name]));
        }
        let (box_min, box_max) = soft_box(scene, &objects);
        let farthest = |own: &Own| own.center.length() + own.scale * own.own_radius;
        let soft_radius = objects.iter().map(farthest).fold(0.0, f32::max);
        let center = 0.5 * (box_min + box_max);
        let reach = match objects.as_slice() {
            [own] => own.radius,
            all => {
                let within = all.iter().map(|own| own.center.distance(center) + own.radius).fold(0.0, f32::max);
                within.min(0.5 * box_min.distance(box_max))
            }
        };

        let turn = camera.turn(); // the trackball
        let stretch = Vec3::from(scene.object.stretch);
        let half_height = reach * stretch.max_element() / FILL / camera.zoom;
        let [width, height] = scene.image.size.map(|side| side as f32);
        let (aspect, fit) = (width / height, (width / height).min(1.0));
        let half_angle = 0.5 * camera.field_of_view.to_radians();
        let radius = (0.5 * (box_max - box_min) * stretch).length();
        let (projection, distance, ray_scale) = match camera.projection {
            Projection::Perspective => {
                let distance = half_height / fit / half_angle.sin();
                let y = half_angle.tan();
                (
                    rh::proj::vulkan::perspective_infinite_reverse(2.0 * half_angle, aspect, NEAR),
                    distance,
                    [y * aspect, y],
                )
            }
            Projection::Parallel => {
                let (distance, y) = (2.0 * radius + NEAR, half_height / fit);
                let far = distance + 2.0 * radius;
                (rh::proj::vulkan::orthographic(-y * aspect, y * aspect, -y, y, 0.0, far), distance, [y * aspect, y])
            }
        };
        // At the depth of the center; in parallel projection, at any.
        let depth = if camera.projection == Projection::Perspective { distance } else { 1.0 };
        let pan = [camera.pan[0] / (ray_scale[0] * depth), -camera.pan[1] / (ray_scale[1] * depth)];
        let center_eye = Vec3::new(0.0, 0.0, -distance);
        let object_matrix = Mat4::from_rotation_translation(turn, center_eye)
            * Mat4::from_scale(stretch)
            * Mat4::from_translation(-center);
        let display_matrix = match camera.slice_stack {
            false => Mat4::IDENTITY,
            true => {
                let tilt = Mat4::from_rotation_x(0.3) * Mat4::from_rotation_y(STACK_TURN.to_radians());
                Mat4::from_translation(center_eye) * tilt * Mat4::from_translation(-center_eye)
            }
        };
        View {
            projection,
            object_matrix,
            texture_matrix: object_matrix.inverse(),
            display_matrix,
            light_eye: center_eye + Vec3::from(scene.light.position),
            objects,
            box_min,
            box_max,
            soft_radius,
            extent: Extent { distance, radius, near: NEAR },
            ray_scale,
            pan,
            slice_stack: camera.slice_stack,
        }
    }

    /// The color of a slice by its place in the stack: white, unless the stack itself is looked at.
    pub(super) fn tint(&self) -> impl Fn(f32) -> [f32; 4] + use<> {
        let slice_stack = self.slice_stack;
        move |place| {
            if slice_stack { [1.0 - 0.8 * place, 0.25 + 0.3 * place, 0.2 + 0.8 * place, 1.0] } else { [1.0; 4] }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::glsl;
    use crate::pass::{Planes, stack};
    use crate::scene::{EFFECTS, Order, Proxy, preset};

    #[test]
    fn m01_the_trackball_turns_the_texture_matrix_and_moves_no_vertex() {
        for effect in EFFECTS {
            let [still, turned] = [(0.0, 0.0), (77.0, -35.0)].map(|(azimuth, elevation)| {
                let mut scene = preset(effect).unwrap();
                scene.object.input = "torus".into();
                (scene.camera.azimuth, scene.camera.elevation) = (azimuth, elevation);
                let subject = Subject::load(&scene, &glsl::shipped(), &|_| ()).unwrap();
                View::of(&scene, &subject, &Variant::of(&scene, &glsl::shipped()).unwrap())
            });
            assert_ne!(still.texture_matrix, turned.texture_matrix, "{effect}");
            assert_eq!(still.projection, turned.projection, "{effect}");
            for proxy in [Proxy::Quads, Proxy::Polygons] {
                let [a, b] = [&still, &turned].map(|view| {
                    let planes = Planes::new(view.extent, 32);
                    stack(&planes, view.extent.radius, proxy, Order::FrontToBack, view.tint())
                });
                assert_eq!(a, b, "{effect}");
            }
        }
    }
}
