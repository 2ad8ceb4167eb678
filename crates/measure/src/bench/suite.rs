//! The rows: effects against their texture fetches, skipping of empty space, growth, encodings and proxies.

use super::roofline::with_peaks;
use crate::compare::paper::numbers;
use hypertexture::field::Request;
use hypertexture::render::{open, request};
use hypertexture::scene::{
    self, EFFECTS, EmptySpace, FieldEncoding, LightMethod, Object, ParameterValue, Pass, Proxy, Scene, SceneError,
    ShaderStage, TargetFormat,
};
use hypertexture::shader::{self, Library};
use hypertexture::shape::{Mesh, Shape};

/// Samples of a ray, or slices, of the effects: twice those of the paper's tables.
const SAMPLES: u32 = 256;
/// Sides of the pictures of the effects, pixels: the smaller window of the paper, and four times its pixels.
const SIDES: [u32; 2] = [300, 600];
/// Sizes of the pictures of the stages, pixels.
const STAGE_SIZES: [[u32; 2]; 3] = [[300, 300], [1024, 768], [1920, 1080]];
/// Phrase for the fragment or compute stage, which `auto` is compared with.
pub(crate) const BETTER_STAGE: &str = "the better stage";
/// Side of the other pictures.
const SIDE: u32 = 128;
/// Voxels along the longest side of an object.
const RESOLUTION: u32 = 128;
/// Octaves, samples, pixels and voxels along a side of the rows that grow.
const OCTAVES: [u32; 5] = [1, 2, 4, 6, 8];
const STEPS: [u32; 4] = [64, 128, 256, 512];
const PIXELS: [u32; 4] = [64, 128, 256, 512];
const VOXELS: [u32; 4] = [32, 64, 128, 256];
/// How often each triangle of the mesh is cut in four.
const CUTS: [u32; 3] = [0, 1, 2];

/// Minimal programs: one fetch, rejected outside of the soft region or else blended; and one more fetch, of noise. The
/// parameter widens their box to that of the effect.
const FLOORS: [(&str, &str); 2] = [("floor_one", "vec4(0.0)"), ("floor_two", "texture(noise_block, 3.0 * x)")];

fn floor(second: &str) -> String {
    format!(
        "// @param floor_reach = 0 in [0, 8]: Reach of the effect beyond its soft region, object units.\n\
         // @grow floor_reach\n\
         #include <softness>\n\
         vec4 classify(vec3 x, float path) {{\n\
             vec4 v = texture(volume, volume_scale.xyz * x + volume_offset.xyz);\n\
             vec4 second = {second};\n\
             float density = soften(distance_decode.x + distance_decode.y * v.a);\n\
             return density <= 0.0 ? vec4(0.0) : vec4(v.rgb + second.rgb, 1.0) * density;\n\
         }}\n"
    )
}

/// The modules that ship, the minimal programs, and those of the peaks.
pub fn library() -> Library {
    FLOORS.iter().fold(with_peaks(shader::shipped()), |library, (name, second)| {
        library.with_module("classify", name, &floor(second))
    })
}

/// Work that is timed.
pub enum Work {
    /// A picture.
    Picture(Box<Scene>),
    /// The distance field of a shape, not from the cache.
    Field(Shape, Request),
}

/// A row of the table.
pub struct Row {
    /// Group, slash, name.
    pub name: String,
    /// Work.
    pub work: Work,
    /// Rows of its group, of which the fastest is compared with, and a phrase for it.
    pub against: Option<(Vec<String>, &'static str)>,
    /// Time in the paper on a GeForce 6800 GT, milliseconds.
    pub paper_ms: Option<f64>,
}

impl Row {
    pub(super) fn picture(name: String, scene: Scene) -> Row {
        Row { name, work: Work::Picture(Box::new(scene)), against: None, paper_ms: None }
    }

    fn against(self, name: &str, what: &'static str) -> Row {
        Row { against: Some((vec![name.into()], what)), ..self }
    }
}

/// All rows, in groups that are timed in turns. `quick` leaves out the larger pictures of the effects and the last step of
/// growth. `names` chooses the rows whose name contains one of them, with the rows that they are compared with.
///
/// # Errors
/// A preset cannot be read, or has no program.
pub fn suite(library: &Library, quick: bool, names: &[String]) -> Result<Vec<Vec<Row>>, SceneError> {
    let mut groups = Vec::new();
    for (number, effect) in EFFECTS.into_iter().enumerate() {
        groups.push(of_effect(library, effect, number, if quick { &SIDES[..1] } else { &SIDES })?);
    }
    for name in scene::names() {
        groups.extend(skipping(library, name)?);
    }
    groups.extend(growth(quick)?);
    groups.extend(variants()?);
    Ok(chosen(groups, names))
}

/// The effects of the paper on a teapot and all presets by rays, in groups of one row for each shader stage that may trace
/// them. `quick` and `names` as in [`suite`].
///
/// # Errors
/// A preset cannot be read.
pub fn stages(quick: bool, names: &[String]) -> Result<Vec<Vec<Row>>, SceneError> {
    let mut groups = Vec::new();
    for size in if quick { &STAGE_SIZES[..1] } else { &STAGE_SIZES } {
        for name in scene::names() {
            let mut scene = scene::preset(name)?;
            if EFFECTS.contains(&name) {
                (scene.object.input, scene.object.resolution) = ("teapot".into(), RESOLUTION);
            }
            (scene.image.size, scene.quality.samples) = (*size, SAMPLES);
            (scene.quality.pass, scene.quality.msaa, scene.quality.target) = (Pass::March, 1, TargetFormat::Float32);
            if scene.is_half_angle() {
                (scene.light.method, scene.light.translucency) = (LightMethod::Volume, 0.0);
            }
            let row = |stage: ShaderStage| {
                let mut scene = scene.clone();
                scene.quality.stage = stage;
                Row::picture(format!("stages/{name}, {} x {}, {}", size[0], size[1], stage.name()), scene)
            };
            let fragment = row(ShaderStage::Fragment);
            let compute = row(ShaderStage::Compute).against(&fragment.name, "fragment");
            let both = vec![fragment.name.clone(), compute.name.clone()];
            let auto = Row { against: Some((both, BETTER_STAGE)), ..row(ShaderStage::Auto) };
            groups.push(vec![fragment, compute, auto]);
        }
    }
    Ok(chosen(groups, names))
}

/// Rows of groups whose name contains one of `names`, with the rows that they are compared with; all without names.
fn chosen(mut groups: Vec<Vec<Row>>, names: &[String]) -> Vec<Vec<Row>> {
    if !names.is_empty() {
        for group in &mut groups {
            let wanted = |row: &Row| names.iter().any(|name| row.name.contains(name));
            let others: Vec<String> = group
                .iter()
                .filter(|row| wanted(row))
                .filter_map(|row| Some(row.against.as_ref()?.0.clone()))
                .flatten()
                .collect();
            group.retain(|row| wanted(row) || others.contains(&row.name));
        }
        groups.retain(|group| !group.is_empty());
    }
    groups
}

/// An effect on an object.
fn scene_of(effect: &str, object: &str, side: u32, samples: u32) -> Result<Scene, SceneError> {
    let mut scene = scene::preset(effect)?;
    (scene.object.input, scene.object.resolution) = (object.into(), RESOLUTION);
    (scene.image.size, scene.quality.samples) = ([side; 2], samples);
    Ok(scene)
}

/// A minimal program over the fragments of an effect.
fn floor_of(effect: &Scene, library: &Library, module: &str) -> Result<Scene, SceneError> {
    let parameters = effect.check(library)?;
    let mut scene = effect.clone();
    scene.effect.classify = module.into();
    scene.object.outer_iso = parameters.outer_iso().unwrap_or(effect.object.outer_iso);
    let reach = ParameterValue::Number(parameters.spread(1.0, 1.0).grows.farthest());
    scene.parameters = [("floor_reach".to_string(), reach)].into();
    Ok(scene)
}

/// An effect of the paper by slices, by their fetches alone, and by rays.
fn of_effect(library: &Library, effect: &str, number: usize, sides: &[u32]) -> Result<Vec<Row>, SceneError> {
    let mut rows = Vec::new();
    // The lit object has one fetch; every other effect fetches noise or turbulence too.
    let module = FLOORS[usize::from(effect != "lit")].0;
    for &side in sides {
        let scene = |pass| {
            let mut scene = scene_of(effect, "teapot", side, SAMPLES)?;
            scene.quality.pass = pass;
            Ok::<_, SceneError>(scene)
        };
        let (slices, name) = (scene(Pass::Slices)?, |how: &str| format!("effects/{effect}, {side} x {side}, {how}"));
        let floor = floor_of(&slices, library, module)?;
        let of_paper = (side == SIDES[0]).then(|| 1e3 / numbers::EFFECTS[number].2[1][0]);
        let own = [
            Row::picture(name("fetches of the slices alone"), floor),
            Row::picture(name("slices"), slices).against(&name("fetches of the slices alone"), "their fetches alone"),
            Row::picture(name("rays"), scene(Pass::March)?).against(&name("slices"), "slices"),
        ];
        rows.extend(own.into_iter().enumerate().map(|(at, row)| Row { paper_ms: of_paper.filter(|_| at > 0), ..row }));
    }
    Ok(rows)
}

/// An example scene with and without skipping of empty space; `None` if it never skips.
fn skipping(library: &Library, name: &str) -> Result<Option<Vec<Row>>, SceneError> {
    let mut scene = scene::preset(name)?;
    scene.image.size = [SIDE; 2];
    scene.quality.pass = Pass::March;
    let mut sampled = scene.clone();
    sampled.quality.empty_space = EmptySpace::Sample;
    if scene.quality.empty_space == EmptySpace::Sample || scene.check(library).and(sampled.check(library)).is_err() {
        return Ok(None);
    }
    let (own, other) = (format!("scenes/{name}"), format!("scenes/{name}, every sample"));
    Ok(Some(vec![
        Row::picture(own.clone(), scene),
        Row::picture(other, sampled).against(&own, "the same with empty space left out"),
    ]))
}

/// Rows that grow with one number.
fn growth(quick: bool) -> Result<Vec<Vec<Row>>, SceneError> {
    const BEFORE: &str = "the row before";
    let few = |values: &[u32]| values[..values.len() - usize::from(quick)].to_vec();
    let grown = |what: &str, values: &[u32], scene: &dyn Fn(u32) -> Result<Scene, SceneError>| {
        let name = |value: u32| format!("growth/{value} {what}");
        let mut rows: Vec<Row> = Vec::new();
        for value in few(values) {
            let row = Row::picture(name(value), scene(value)?);
            let before = rows.last().map(|row| row.name.clone());
            rows.push(match before {
                Some(before) => row.against(&before, BEFORE),
                None => row,
            });
        }
        Ok::<_, SceneError>(rows)
    };
    let fire = || scene_of("fire", "teapot", SIDE, SIDE);
    let octaves = grown("octaves of computed noise, fire", &OCTAVES, &|octaves| {
        let mut scene = fire()?;
        (scene.effect.noise, scene.effect.turbulence) = ("procedural".into(), "procedural".into());
        scene.effect.octaves = octaves;
        Ok(scene)
    })?;
    let steps = grown("samples of a ray, none left out, fire", &STEPS, &|samples| {
        let mut scene = fire()?;
        (scene.quality.samples, scene.quality.empty_space) = (samples, EmptySpace::Sample);
        Ok(scene)
    })?;
    let pixels = grown("pixels along a side, fire", &PIXELS, &|side| scene_of("fire", "teapot", side, SIDE / 2))?;
    let voxels = grown("voxels along a side, lit knot", &VOXELS, &|voxels| {
        let mut scene = scene_of("lit", "knot", 2 * SIDE, SIDE)?;
        scene.object.resolution = voxels;
        Ok(scene)
    })?;
    Ok(vec![octaves, steps, pixels, voxels, fields(&few(&CUTS))])
}

/// The lit torus in each encoding of its field, and lit objects by quads and by polygons.
fn variants() -> Result<Vec<Vec<Row>>, SceneError> {
    let sources = [
        ("formula", FieldEncoding::Auto),
        ("normals8", FieldEncoding::Normals8),
        ("normals16", FieldEncoding::Normals16),
        ("distance16", FieldEncoding::Distance16),
        ("distance32", FieldEncoding::Distance32),
    ];
    let mut encodings = Vec::new();
    for (name, source) in sources {
        let mut scene = scene_of("lit", "torus", 2 * SIDE, SIDE)?;
        (scene.object.field_encoding, scene.quality.pass) = (source, Pass::Slices);
        let row = Row::picture(format!("encodings/lit torus, {name}"), scene);
        encodings.push(if source == FieldEncoding::Auto {
            row
        } else {
            row.against("encodings/lit torus, formula", "the formula")
        });
    }
    let mut groups = vec![encodings];
    for object in ["sphere", "torus", "cube"] {
        let row = |proxy, name| {
            let mut scene = scene_of("lit", object, 2 * SIDE, SIDE)?;
            (scene.quality.pass, scene.quality.proxy) = (Pass::Slices, proxy);
            Ok::<_, SceneError>(Row::picture(format!("proxies/lit {object}, {name}"), scene))
        };
        let quads = row(Proxy::Quads, "quads")?;
        let polygons = row(Proxy::Polygons, "polygons")?.against(&quads.name, "quads");
        groups.push(vec![quads, polygons]);
    }
    Ok(groups)
}

/// Distance fields of one surface in more and more triangles.
fn fields(cuts: &[u32]) -> Vec<Row> {
    let object = Object { input: "teapot".into(), resolution: RESOLUTION, ..Object::default() };
    let Ok(Shape::Mesh(teapot)) = open(&object) else { return Vec::new() };
    let mut rows: Vec<Row> = Vec::new();
    for &cuts in cuts {
        let shape = Shape::Mesh((0..cuts).fold(teapot.clone(), |mesh, _| cut(&mesh)));
        let request = request(&shape, &object, 0.25);
        let name = format!("growth/{} triangles, field of {RESOLUTION} voxels", teapot.triangles.len() << (2 * cuts));
        let against = rows.last().map(|row| (vec![row.name.clone()], "the row before"));
        rows.push(Row { name, work: Work::Field(shape, request), against, paper_ms: None });
    }
    rows
}

/// Cuts each triangle in four at the middles of its sides; the surface stays.
fn cut(mesh: &Mesh) -> Mesh {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for index in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(index);
        let first = positions.len() as u32;
        positions.extend([a, b, c, 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)]);
        triangles.extend(
            [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]].map(|corners| corners.map(|corner: u32| first + corner)),
        );
    }
    Mesh { positions, triangles, ..Mesh::default() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hypertexture::shape;
    use std::collections::BTreeSet;

    #[test]
    fn rows_are_valid_scenes_with_distinct_names() {
        let library = library();
        let groups = suite(&library, false, &[]).unwrap();
        let rows: Vec<&Row> = groups.iter().flatten().collect();
        let names: BTreeSet<&str> = rows.iter().map(|row| row.name.as_str()).collect();
        assert_eq!(names.len(), rows.len());
        for row in &rows {
            if let Work::Picture(scene) = &row.work {
                scene.check(&library).unwrap_or_else(|error| panic!("{}: {error}", row.name));
            }
        }
        for group in &groups {
            for other in group.iter().filter_map(|row| row.against.as_ref()).flat_map(|(others, _)| others) {
                assert!(group.iter().any(|row| row.name == *other), "{other} is in the group");
            }
        }
        for effect in EFFECTS {
            assert!(names.contains(format!("effects/{effect}, 300 x 300, rays").as_str()));
        }
        assert!(suite(&library, true, &[]).unwrap().iter().flatten().count() < rows.len());
    }

    #[test]
    fn names_choose_rows_and_their_comparisons() {
        let chosen = suite(&library(), false, &["lit, 300 x 300, rays".into()]).unwrap();
        let names: Vec<&str> = chosen.iter().flatten().map(|row| row.name.as_str()).collect();
        assert_eq!(names, ["effects/lit, 300 x 300, slices", "effects/lit, 300 x 300, rays"]);
        assert!(suite(&library(), false, &["nothing of that name".into()]).unwrap().is_empty());
    }

    #[test]
    fn cut_triangles_are_the_same_surface() {
        let Ok(Shape::Mesh(teapot)) = shape::open("teapot") else { panic!("the teapot is a mesh") };
        let fine = cut(&teapot);
        assert_eq!(fine.triangles.len(), 4 * teapot.triangles.len());
        assert_eq!((fine.open_edges(), fine.bounds()), (2 * teapot.open_edges(), teapot.bounds()));
        assert!((fine.signed_volume() / teapot.signed_volume() - 1.0).abs() < 1e-6);
    }
}
