//! Matrices and bounds of a scene.
//!
//! Eye space: the camera at the origin, looking along -z, y up; one unit is one object unit. The slices live there, and
//! the rotation of the object reaches them through the texture matrix alone (MJ 3.3).

use super::planes::{Extent, SlicePlanes};
use crate::render::subject::Subject;
use crate::render::variant::Variant;
use crate::scene::{Parameters, Projection, Scene, Spread, Transform};
use crate::shader::slots::MAIN;
use glam::camera::rh;
use glam::{Mat4, Vec2, Vec3};

/// Share of the picture's height that the object fills at zoom 1, unless its soft region would be cut off.
const FILL: f32 = 0.8;
/// Largest share of the picture's height that the soft region fills at zoom 1.
const SOFT_FILL: f32 = 0.97;
/// Near plane, object units. Lower: the perspective division loses its digits.
const NEAR: f32 = 1e-3;
/// Turn of the slice stack for a view from the side, degrees (MJ Fig. 1).
const STACK_TURN: f32 = 62.0;

/// Lowest cosine of the angle between a ray and the slice normal (80 degrees). Lower: a path inside one slice exceeds
/// six steps.
pub(crate) const FLATTEST: f32 = 0.17;

/// Matrices and bounds of a scene.
#[derive(Clone)]
pub(crate) struct View {
    pub(crate) projection: Mat4,
    pub(crate) object_matrix: Mat4,
    pub(crate) texture_matrix: Mat4,
    pub(crate) display_matrix: Mat4,
    pub(crate) light_eye: Vec3,
    /// The main object, then the additional ones.
    pub(crate) objects: Vec<ObjectView>,
    pub(crate) box_min: Vec3,
    pub(crate) box_max: Vec3,
    /// Radius of a ball around the origin of object space that contains all matter.
    pub(crate) soft_radius: f32,
    pub(crate) extent: Extent,
    /// Middle of the scene in eye space; on the axis of view unless the camera is given by matrices.
    pub(crate) center_eye: Vec3,
    /// Radius of the ball that fills the picture at zoom 1, eye space.
    pub(crate) shown_radius: f32,
    /// Slice normal in eye space: toward the camera, or halfway to the light.
    pub(crate) axis: Vec3,
    /// Half width and height of the view: at depth 1 in perspective, at any depth in parallel projection.
    pub(crate) ray_scale: [f32; 2],
    /// Shift of the picture to the right and down; its edges are at -1 and 1.
    pub(crate) pan: [f32; 2],
    slice_stack: bool,
}

/// Placement and bounds of one object.
#[derive(Clone)]
pub(crate) struct ObjectView {
    /// Name in the scene; empty for the main object.
    pub(crate) name: String,
    /// From the object's own space to object space of the scene.
    pub(crate) place: Mat4,
    /// Scene units in one unit of the object.
    pub(crate) scale: f32,
    /// Signed distance at which the soft region starts, own units.
    pub(crate) outer_iso: f32,
    /// Box around the soft region, own space.
    pub(crate) own_min: Vec3,
    pub(crate) own_max: Vec3,
    /// Radius of a ball around the origin that contains all matter, own space.
    pub(crate) own_radius: f32,
    /// Bounds of the displacement of lookups and of matter by warps.
    pub(crate) spread: Spread,
    /// Half size of the unwarped soft region, own space.
    half_size: Vec3,
    /// Heights up to which nothing and from which all of the effect is there, own space; 0 without a kept base.
    pub(crate) base: [f32; 2],
    /// Sphere around the object without its soft region, object space of the scene.
    center: Vec3,
    radius: f32,
    /// Width of the soft region, object space of the scene.
    soft: f32,
}

impl ObjectView {
    fn of(name: &str, place: Transform, scene: &Scene, subject: &Subject, parameters: &Parameters) -> ObjectView {
        // The scene decides, not the program: pre-classification softens voxels, and its program is hard.
        let soft = scene.effect.softness != "hard";
        let declared = parameters.outer_iso().unwrap_or(scene.object.outer_iso);
        let outer_iso = if soft { declared } else { scene.object.inner_iso };
        let half_size = subject.half_size + outer_iso.max(0.0);
        // The radius is that of samples inside: the surface is at most a voxel farther out, plus rounding.
        let voxel = subject.field.as_ref().map_or(0.0, |field| field.grid.spacing.length() * subject.scale);
        let radius = 1.0001 * (subject.radius + voxel + outer_iso.max(0.0));
        let spread = parameters.spread(radius, subject.strength());
        ObjectView {
            name: name.into(),
            place: place.matrix(),
            scale: place.scale,
            outer_iso,
            own_min: -half_size - spread.grows.round - Vec3::from(spread.grows.low),
            own_max: half_size + spread.grows.round + Vec3::from(spread.grows.high),
            own_radius: radius + spread.grows.farthest(),
            spread,
            half_size,
            base: base(scene.effect.keep_base, subject.half_size.y),
            center: Vec3::from(place.at),
            radius: place.scale * subject.radius,
            soft: place.scale * outer_iso.max(0.0),
        }
    }

    /// Box in object space of the scene around a box in the object's own space.
    fn around(&self, low: Vec3, high: Vec3) -> (Vec3, Vec3) {
        let corners = (0..8).map(|corner| {
            let pick = |axis: usize| if corner >> axis & 1 == 1 { high[axis] } else { low[axis] };
            self.place.transform_point3(Vec3::new(pick(0), pick(1), pick(2)))
        });
        corners.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), corner| (low.min(corner), high.max(corner)))
    }

    /// Upper bound of the distance from a point to any matter, object space of the scene.
    fn farthest(&self, from: Vec3) -> f32 {
        self.center.distance(from) + self.scale * self.own_radius
    }
}

/// Part of the height of a kept base over which the effect sets in above it.
const BASE_FADE: f32 = 0.25;

/// Heights between which the effect sets in, of an object from -half to half.
fn base(kept: f32, half: f32) -> [f32; 2] {
    if kept > 0.0 { [kept - half, (1.0 + BASE_FADE) * kept - half] } else { [0.0; 2] }
}

/// Evaluates the boolean formula of a scene over a bound `of` each object; `both` combines bounds for an intersection,
/// `either` for a union.
fn whole<T>(
    scene: &Scene,
    objects: &[ObjectView],
    of: impl Fn(&ObjectView) -> T,
    both: impl Fn(T, T) -> T,
    either: impl Fn(T, T) -> T,
) -> T {
    if let [own] = objects {
        return of(own); // its formula is its name
    }
    let named = |name: &str| objects.iter().find(|own| own.name == name || (own.name.is_empty() && name == MAIN));
    let of_name = |name: &str| of(named(name).unwrap_or(&objects[0]));
    let bound = scene.formula().ok().and_then(|formula| formula.bound(&of_name, &both, &either));
    bound.unwrap_or_else(|| objects[1..].iter().map(&of).fold(of(&objects[0]), &either))
}

/// Box of the scene, from a box of each of its objects, object space of the scene.
fn box_of(scene: &Scene, objects: &[ObjectView], of: impl Fn(&ObjectView) -> (Vec3, Vec3)) -> (Vec3, Vec3) {
    let both = |a: (Vec3, Vec3), b: (Vec3, Vec3)| {
        let (low, high) = (a.0.max(b.0), a.1.min(b.1));
        if low.cmplt(high).all() { (low, high) } else { a } // disjoint objects: the intersection is empty
    };
    whole(scene, objects, of, both, |a, b| (a.0.min(b.0), a.1.max(b.1)))
}

/// Largest distance from the center of a point that lies in a ball and in a box around it, after a stretch of both. The
/// radius is spent on the most stretched axes first, up to the sides of the box.
fn farthest(half_size: Vec3, radius: f32, stretch: Vec3) -> f32 {
    let mut axes = [0, 1, 2];
    axes.sort_by(|&a, &b| stretch[b].total_cmp(&stretch[a]));
    let (mut left, mut sum) = (radius * radius, 0.0);
    for axis in axes {
        let taken = left.min(half_size[axis] * half_size[axis]);
        sum += stretch[axis] * stretch[axis] * taken;
        left -= taken;
    }
    sum.sqrt()
}

/// Half the height of the view at the depth of the middle of the scene, object units: the unit of
/// [`crate::scene::Camera::pan`].
pub fn half_height(variant: &Variant, subject: &Subject) -> f32 {
    let view = View::of(variant, subject);
    match variant.scene.projection() {
        Projection::Perspective => view.ray_scale[1] * view.extent.distance,
        Projection::Parallel => view.ray_scale[1],
    }
}

impl View {
    pub(crate) fn of(variant: &Variant, subject: &Subject) -> View {
        let scene = &variant.scene;
        let camera = &scene.camera;
        let mut objects = vec![ObjectView::of("", Transform::default(), scene, subject, &variant.parameters)];
        for (name, part) in &scene.parts {
            objects.push(ObjectView::of(
                name,
                part.transform,
                &scene.part_as_scene(name),
                &subject.parts[name],
                &variant.parts[name],
            ));
        }
        let (box_min, box_max) = box_of(scene, &objects, |own| own.around(own.own_min, own.own_max));
        // The target of the camera does not move with drips: warps do not widen this box.
        let (core_min, core_max) = box_of(scene, &objects, |own| own.around(-own.half_size, own.half_size));
        let center = 0.5 * (core_min + core_max);
        let ball = |from: Vec3| whole(scene, &objects, |own| own.farthest(from), f32::min, f32::max);
        // Half of the visible size; `soft` is the share of the soft regions in it.
        let shown = |soft: f32| match objects.as_slice() {
            [own] => own.radius + soft * own.soft,
            all => {
                let of = |own: &ObjectView| own.center.distance(center) + own.radius + soft * own.soft;
                all.iter().map(of).fold(0.0, f32::max).min(0.5 * box_min.distance(box_max))
            }
        };
        let reach = (shown(0.0) / FILL).max(shown(1.0) / SOFT_FILL);

        let lens = scene.lens().ok().flatten(); // checked with the scene
        let turn = lens.map_or_else(|| camera.turn(), |lens| lens.turn);
        let stretch = Vec3::from(scene.object.stretch);
        let half_height = reach * stretch.max_element() / camera.zoom;
        let shown_radius = shown(0.0) * stretch.max_element();
        let [width, height] = scene.image.size.map(|side| side as f32);
        let (aspect, fit) = (width / height, (width / height).min(1.0));
        let half_angle = 0.5 * camera.field_of_view.to_radians();
        let half_size = (box_max - center).max(center - box_min);
        let (soft_radius, radius) = (ball(Vec3::ZERO), farthest(half_size, ball(center), stretch));
        let (projected, nearest) = (scene.projection(), Vec3::new(0.0, 0.0, -(2.0 * radius + NEAR)));
        let is_parallel = projected == Projection::Parallel;
        let (center_eye, ray_scale, pan) = match lens {
            Some(lens) => {
                let origin = if lens.is_far { nearest } else { lens.origin };
                (lens.turn * center + origin, lens.ray_scale, lens.pan)
            }
            None => {
                let (distance, y) = match projected {
                    Projection::Perspective => (half_height / fit / half_angle.sin(), half_angle.tan()),
                    Projection::Parallel => (2.0 * radius + NEAR, half_height / fit),
                };
                let ray_scale = [y * aspect, y];
                // At the depth of the center; in parallel projection, at any.
                let depth = if is_parallel { 1.0 } else { distance };
                let pan = [camera.pan[0] / (ray_scale[0] * depth), -camera.pan[1] / (ray_scale[1] * depth)];
                (Vec3::new(0.0, 0.0, -distance), ray_scale, pan)
            }
        };
        let distance = -center_eye.z;
        let ([x, y], far) = (ray_scale, (distance + 2.0 * radius).max(NEAR));
        let projection = match (projected, lens) {
            (Projection::Parallel, _) => rh::proj::vulkan::orthographic(-x, x, -y, y, 0.0, far),
            (_, None) => rh::proj::vulkan::perspective_infinite_reverse(2.0 * half_angle, aspect, NEAR),
            (_, Some(_)) => rh::proj::vulkan::perspective_infinite_reverse(2.0 * y.atan(), x / y, NEAR),
        };
        let object_matrix = Mat4::from_rotation_translation(turn, center_eye)
            * Mat4::from_scale(stretch)
            * Mat4::from_translation(-center);
        let display_matrix = if camera.slice_stack {
            let tilt = Mat4::from_rotation_x(0.3) * Mat4::from_rotation_y(STACK_TURN.to_radians());
            Mat4::from_translation(center_eye) * tilt * Mat4::from_translation(-center_eye)
        } else {
            Mat4::IDENTITY
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
            center_eye,
            shown_radius,
            axis: axis(scene),
            ray_scale,
            pan,
            slice_stack: camera.slice_stack,
        }
    }

    /// Position of the eye in object space, where it may be in matter; `None` of parallel rays, and outside of the scene's box.
    pub(crate) fn eye(&self) -> Option<Vec3> {
        let eye = self.texture_matrix.transform_point3(Vec3::ZERO);
        let is_within = self.box_min.cmple(eye).all() && eye.cmple(self.box_max).all();
        (is_within && self.extent.near + self.extent.radius > self.extent.distance).then_some(eye)
    }

    /// Planes of the slices. Half-angle slices are complete, since the light passes through all of them.
    pub(crate) fn planes(&self, samples: u32) -> SlicePlanes {
        if self.axis == Vec3::Z {
            SlicePlanes::new(self.extent, samples)
        } else {
            let distance = -self.axis.dot(self.center_eye);
            SlicePlanes::new(Extent { distance, near: f32::NEG_INFINITY, ..self.extent }, samples)
        }
    }

    /// Upper bounds of the scene's extent from the axis of view and from the eye.
    pub(crate) fn reaches(&self) -> [f32; 2] {
        let aside = self.center_eye.truncate().length();
        [aside + self.extent.radius, aside + self.extent.distance.abs() + self.extent.radius]
    }

    /// Color of a slice by its place in the stack: white, unless the stack is viewed from the side.
    pub(crate) fn tint(&self) -> impl Fn(f32) -> [f32; 4] + use<> {
        let slice_stack = self.slice_stack;
        move |place| {
            if slice_stack { [1.0 - 0.8 * place, 0.25 + 0.3 * place, 0.2 + 0.8 * place, 1.0] } else { [1.0; 4] }
        }
    }
}

/// Slice normal of a scene in eye space, on the side of the light; z for view-aligned slices.
pub(crate) fn axis(scene: &Scene) -> Vec3 {
    let to_light = Vec3::from(scene.light.position).normalize_or(Vec3::Z);
    match scene.is_half_angle() {
        true if to_light.z >= 0.0 => (to_light + Vec3::Z).normalize(),
        true => (to_light - Vec3::Z).normalize(),
        false => Vec3::Z,
    }
}

/// Largest path of a ray between two planes, relative to their distance.
pub(crate) fn slant(scene: &Scene, view: &View) -> f32 {
    let farthest = (Vec2::from(view.pan).abs() + 1.0) * Vec2::from(view.ray_scale);
    let signs = [Vec2::ONE, Vec2::NEG_ONE, Vec2::new(1.0, -1.0), Vec2::new(-1.0, 1.0)];
    let along = signs.map(|sign| match scene.projection() {
        Projection::Parallel => Vec3::NEG_Z,
        Projection::Perspective => (sign * farthest).extend(-1.0),
    });
    let toward = -view.axis * view.axis.z.signum();
    along.iter().map(|ray| ray.length() / ray.dot(toward).max(FLATTEST * ray.length())).fold(1.0, f32::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::frame::stack;
    use crate::scene::{EFFECTS, LightMethod, Order, Pass, Proxy, preset};
    use crate::shader;

    #[test]
    fn m01_the_trackball_turns_the_texture_not_the_vertices() {
        for (effect, method) in
            EFFECTS.into_iter().flat_map(|effect| [LightMethod::Volume, LightMethod::HalfAngle].map(|m| (effect, m)))
        {
            let [still, turned] = [(0.0, 0.0), (77.0, -35.0)].map(|(azimuth, elevation)| {
                let mut scene = preset(effect).unwrap();
                scene.object.input = "torus".into();
                (scene.light.shadows, scene.light.method, scene.light.position) = (true, method, [6.0, 1.0, -3.0]);
                scene.quality.pass = Pass::Slices;
                (scene.camera.azimuth, scene.camera.elevation) = (azimuth, elevation);
                let subject = Subject::load(&scene, &shader::shipped(), &|_| ()).unwrap();
                View::of(&Variant::of(&scene, &shader::shipped()).unwrap(), &subject)
            });
            assert_ne!(still.texture_matrix, turned.texture_matrix, "{effect}");
            assert_eq!((still.projection, still.axis), (turned.projection, turned.axis), "{effect}");
            assert_eq!(still.axis == Vec3::Z, method == LightMethod::Volume);
            for proxy in [Proxy::Quads, Proxy::Polygons] {
                let [a, b] = [&still, &turned].map(|view| {
                    let planes = view.planes(32);
                    stack(&planes, view.extent.radius, proxy, Order::FrontToBack, view.tint())
                });
                assert_eq!(a, b, "{effect}");
            }
        }
    }
}
