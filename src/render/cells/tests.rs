//! Soundness of empty cells.

use super::grid::distances;
use super::prover::{BoundedProgram, CellGrid, CellProver, packed, unpacked};
use super::{bounded_noise, slice_tiles};
use crate::eval;
use crate::gpu::Area;
use crate::render::camera::{FrameContext, SubFrame};
use crate::render::error::RenderError;
use crate::render::inputs::{CpuInputs, ImageInfo, Inputs, Values};
use crate::render::subject::Subject;
use crate::render::variant::{OCTAVES_ID, PassImage, Program, Purpose, Variant};
use crate::scene::{Order, Pass, Projection, RayPath, Scene, names, preset};
use crate::shader::{self, Library, Linker, ParameterKind};
use hypertexture_support::random::SplitMix;

/// Samples of the cells of one scene.
const SAMPLES_OF_A_SCENE: usize = 20_000;

#[test]
fn a_cell_knows_how_far_it_is_to_the_next_that_may_hold_matter() {
    let side = 5;
    let at = |index: usize| [index % side, index / side % side, index / side / side].map(|at| at as i32);
    let full = [7, 93];
    let empty: Vec<bool> = (0..side.pow(3)).map(|index| !full.contains(&index)).collect();
    for (index, &found) in distances(&empty, side).iter().enumerate() {
        let away = |other: &usize| [0, 1, 2].map(|axis| (at(index)[axis] - at(*other)[axis]).abs()).into_iter().max();
        let expected = full.iter().filter_map(away).min();
        assert_eq!(Some(i32::from(found)), expected, "{:?}", at(index));
    }
    assert_eq!(distances(&[true; 8], 2), [u8::MAX; 8]);
}

/// Context of a scene with its loaded subject.
fn context(scene: &Scene, library: &Library) -> FrameContext {
    FrameContext::of(Variant::of(scene, library).unwrap(), &Subject::load(scene, library, &|_| ()).unwrap())
}

/// The prover of a scene, and the values of its first picture, which are set.
pub(super) struct Loaded {
    pub(super) frame: FrameContext,
    pub(super) bounded: Box<BoundedProgram>,
    pub(super) values: Values,
    program: Program,
    read: Vec<u64>,
}

pub(super) fn loaded(scene: &Scene, library: &Library) -> Loaded {
    let frame = context(scene, library);
    let program = frame.variant.program(library, Linker::new).unwrap();
    let inputs = Inputs::new(library, &frame, &program, &|_| ()).unwrap();
    let CellProver::Ready(mut bounded) = prover(library, &frame, (&program, &inputs), |_| true) else {
        panic!("{}", frame.variant.key())
    };
    let values = inputs.stored().values(&frame, &SubFrame::all(scene).next().unwrap());
    let read = bounded.fill(&values, [values.time; 2]).unwrap();
    Loaded { frame, bounded, values, program, read }
}

/// A loaded prover of a program and its inputs.
fn prover(
    library: &Library,
    frame: &FrameContext,
    (program, inputs): (&Program, &Inputs),
    pays: impl Fn(u64) -> bool,
) -> CellProver {
    let image_of = |name: &str| {
        let binding = program.binding(name)?;
        let (_, image) = inputs.images.iter().find(|(own, _)| *own == binding)?;
        let bits = 8 * image.format.bytes() as u32 / image.format.channels();
        let (name, channels, bytes) = (image.image.label().into(), image.format.channels(), image.bytes.len() as u64);
        Some(ImageInfo { name, size: image.dimension.size(), channels, bits, bytes })
    };
    let mut prover = CellProver::new(library, frame, &image_of, pays).unwrap();
    prover.wait(&|| false).unwrap();
    prover
}

#[test]
fn what_decides_is_made_where_it_pays() {
    let (library, mut scene) = (shader::shipped(), preset("melting").unwrap());
    scene.object.resolution = 32;
    let frame = context(&scene, &library);
    let voxels = frame.subject.field.as_ref().unwrap().grid.size.iter().map(|side| u64::from(*side)).product();
    let program = frame.variant.program(&library, Linker::new).unwrap();
    let inputs = Inputs::new(&library, &frame, &program, &|_| ()).unwrap();
    for pays in [false, true] {
        match prover(&library, &frame, (&program, &inputs), |texels| pays && texels >= voxels) {
            CellProver::Idle(texels) => assert!(!pays && texels >= voxels, "{texels} of {voxels}"),
            CellProver::Ready(made) => assert!(pays && made.texels >= voxels),
            CellProver::Loading(..) => panic!("it was waited for"),
            CellProver::Unavailable(why) => panic!("{why}"),
        }
    }
}

#[test]
fn cells_end_where_something_else_is_to_be_done() {
    let (library, mut scene) = (shader::shipped(), preset("melting").unwrap());
    scene.object.resolution = 32;
    let frame = context(&scene, &library);
    let mut prover = CellProver::new(&library, &frame, &|_| None, |_| true).unwrap();
    // Loading may finish before `stop` is asked.
    let stopped = matches!(prover.wait(&|| true), Err(RenderError::Stopped));
    assert_eq!(matches!(prover, CellProver::Loading(..)), stopped);
    prover.wait(&|| false).unwrap();
    let Loaded { bounded, .. } = loaded(&scene, &library);
    let boxes = CellGrid::of(&frame, 8);
    assert!(bounded.empty(&boxes, &|| true).unwrap().is_none());
    assert!(bounded.empty(&boxes, &|| false).unwrap().is_some());
}

/// The drawn program of matter, without replaced noise.
pub(super) fn drawn(scene: &Scene, library: &Library, frame: &FrameContext) -> (eval::Program, eval::Inputs) {
    let variant = Variant { scene: scene.clone(), ..Variant::clone(&frame.variant) };
    let program = variant.for_purpose(Purpose::Cells, library).unwrap().program(library, Linker::new).unwrap();
    let code = eval::Program::read(&program.fragment, &[(OCTAVES_ID, scene.effect.octaves)]).unwrap();
    let read = CpuInputs::new(library, &variant, &frame.subject, &program).unwrap();
    let blocks = read.moments(&program).unwrap().swap_remove(0);
    (code, eval::Inputs { blocks, ..read.exact() })
}

/// Number of empty cells of a scene, and number of samples with matter in them.
fn judge(scene: &Scene, side: u32, random: &mut SplitMix, samples: usize) -> (usize, usize) {
    let library = shader::shipped();
    let Loaded { frame, bounded, program, .. } = loaded(scene, &library);
    assert!(program.reads_image(PassImage::Cells), "{}", frame.variant.key());
    let boxes = CellGrid::of(&frame, side);
    let empty = bounded.empty(&boxes, &|| false).unwrap().unwrap();
    let which: Vec<u32> = (0..side.pow(3)).filter(|&index| empty[index as usize]).collect();
    if which.is_empty() {
        return (0, 0);
    }
    let places = (0..samples).map(|_| {
        let index = which[(random.bits() % which.len() as u64) as usize];
        let cell = boxes.cell([index % side, index / side % side, index / side / side], side);
        // Clamping weights the faces of the box.
        cell.map(|range| range.lo + (range.hi - range.lo) * (1.5 * random.unit() - 0.25).clamp(0.0, 1.0))
    });
    let lanes = eval::Invocations { fragment_coordinates: Vec::new(), varyings: [(0, places.collect())].into() };
    let (code, inputs) = drawn(scene, &library, &frame);
    let outputs = code.bind(&inputs).unwrap().run::<f64>(&lanes).unwrap();
    (which.len(), outputs[&0].iter().filter(|[.., alpha]| alpha.is_nan() || *alpha > 0.0).count())
}

#[test]
fn proofs_are_kept_under_all_that_they_depend_on() {
    let library = shader::shipped();
    let made = |change: &dyn Fn(&mut Scene)| {
        let mut scene = preset("melting").unwrap();
        (scene.object.input, scene.object.resolution) = ("knot".into(), 32);
        change(&mut scene);
        let Loaded { frame, bounded, read, .. } = loaded(&scene, &library);
        (bounded, read, CellGrid::of(&frame, 8))
    };
    let (bounded, read, boxes) = made(&|_| ());
    let key = bounded.key(&boxes, &read);
    let (same, of_same, _) = made(&|scene| (scene.camera.azimuth, scene.light.intensity) = (77.0, 0.5));
    assert_eq!(same.key(&boxes, &of_same), key, "neither view nor light is matter");
    let mut finer = boxes;
    finer.side = 16;
    assert_ne!(bounded.key(&finer, &read), key);
    let changes: [&dyn Fn(&mut Scene); 4] = [
        &|scene| scene.object.input = "pawn".into(),
        &|scene| scene.object.resolution = 33,
        &|scene| scene.quality.block_size = 32,
        &|scene| scene.set_field("parameters.melt_time", "0.3").unwrap(),
    ];
    for (index, change) in changes.into_iter().enumerate() {
        let (other, read, _) = made(change);
        assert_ne!(other.key(&boxes, &read), key, "{index}");
    }
    let empty = bounded.empty(&boxes, &|| false).unwrap().unwrap();
    assert!(empty.contains(&true) && empty.contains(&false));
    let bytes = packed(&empty);
    assert_eq!(unpacked(&bytes, empty.len()), Some(empty));
    assert_eq!(unpacked(&bytes, bytes.len() * 8 + 1), None);
}

/// Computed noise and turbulence modules.
const COMPUTED: [[&str; 2]; 6] = [
    ["procedural", "procedural"],
    ["tables", "octaves"],
    ["wavelet", "octaves"],
    ["arrays", "hybrid"],
    ["procedural", "tables"],
    ["wavelet", "arrays"],
];

/// Sets noise and turbulence of all objects, within the limits of wavelets; whether the scene is valid.
fn compute_noise(scene: &mut Scene, library: &Library, [noise, turbulence]: [&str; 2]) -> bool {
    let mut other = scene.clone();
    if noise == "wavelet" {
        (other.effect.octaves, other.quality.samples) = (other.effect.octaves.min(3), 40);
    }
    let parts = other.parts.values_mut().map(|part| &mut part.effect);
    for effect in parts.chain([&mut other.effect]) {
        (effect.noise, effect.turbulence) = (noise.into(), turbulence.into());
    }
    let takes = other.check(library).is_ok();
    if takes {
        *scene = other;
    }
    takes
}

#[test]
fn m61_noise_that_bounds_look_up_is_the_noise_that_is_computed() {
    let library = shader::shipped();
    let mut random = SplitMix(1985);
    let scenes = [("clouds", "quintic"), ("fire_ball", "cubic"), ("flow", "quintic")];
    for ((name, weights), of) in scenes.into_iter().flat_map(|scene| COMPUTED.map(|of| (scene, of))) {
        let mut scene = preset(name).unwrap();
        (scene.quality.pass, scene.effect.weights) = (Pass::March, weights.into());
        assert!(compute_noise(&mut scene, &library, of), "{name}, {of:?}");
        let Loaded { frame, bounded, .. } = loaded(&scene, &library);
        assert!(!bounded.inputs.noises.is_empty(), "{name}, {of:?}");
        let whole = CellGrid::of(&frame, 1).cell([0; 3], 1);
        let places = (0..20_000).map(|_| whole.map(|range| range.lo + (range.hi - range.lo) * random.unit())).collect();
        let lanes = eval::Invocations { fragment_coordinates: Vec::new(), varyings: [(0, places)].into() };
        let looked_up = bounded.code.bind(&bounded.inputs).unwrap().run::<f64>(&lanes).unwrap();
        let (code, inputs) = drawn(&scene, &library, &frame);
        let computed = code.bind(&inputs).unwrap().run::<f64>(&lanes).unwrap();
        let (mut seen, mut most) = (0, 0f64);
        for (a, b) in looked_up[&0].iter().zip(&computed[&0]) {
            most = most.max((a[0] - b[3]).abs());
            seen += usize::from(b[3] > 0.0 && b[3] < 1.0);
        }
        println!("{name}, {of:?}: {most:.1e} apart, {seen} places within matter");
        assert!(most < 2e-6, "{name}, {of:?}: {most}");
        assert!(seen > 100, "{name}, {of:?}: {seen}");
    }
}

#[test]
fn noise_is_not_looked_up_in_place_of_cells_that_a_module_reads() {
    let mut scene = preset("noisy_sphere").unwrap();
    scene.effect.dmf = vec!["own".into()];
    for (look_up, known) in [("d", true), ("d * textureLod(cell_grid, s.x, 0.0).w", false)] {
        let text = format!("float own(float d, Sample s) {{ return {look_up}; }}");
        let library = shader::shipped().with_module("dmf", "own", &text);
        assert!(compute_noise(&mut scene, &library, COMPUTED[0]));
        let cells = Variant::of(&scene, &library).unwrap().for_purpose(Purpose::Cells, &library).unwrap();
        assert_eq!(bounded_noise::ranged(&cells, &library).is_some(), known, "{look_up}");
    }
}

#[test]
fn m61_computed_and_block_noise_have_similar_empty_cells() {
    let library = shader::shipped();
    let mut random = SplitMix(2005);
    for name in ["noisy_sphere", "fractal_sphere", "clouds", "flow"] {
        let mut scene = preset(name).unwrap();
        scene.quality.pass = Pass::March;
        let (of_a_block, _) = judge(&scene, 16, &mut random, 1);
        for of in COMPUTED {
            let mut scene = scene.clone();
            assert!(compute_noise(&mut scene, &library, of), "{name}, {of:?}");
            let (computed, wrong) = judge(&scene, 16, &mut random, SAMPLES_OF_A_SCENE);
            println!("{name}, {of:?}: {computed} cells are empty, {of_a_block} of a block");
            assert_eq!(wrong, 0, "{name}, {of:?}");
            assert!(2 * computed > of_a_block, "{name}, {of:?}: {computed} of {of_a_block}");
        }
    }
}

#[test]
fn m61_cells_that_are_called_empty_hold_no_matter() {
    // HYPERTEXTURE_SCENES=200 asks for 200 scenes with other parameters, and for 500 000 samples of each.
    let asked: Option<usize> = std::env::var("HYPERTEXTURE_SCENES").ok().and_then(|count| count.parse().ok());
    let (count, samples) = asked.map_or((12, SAMPLES_OF_A_SCENE), |count| (count, 25 * SAMPLES_OF_A_SCENE));
    let library = shader::shipped();
    let mut random = SplitMix(1989);
    let (mut cells, mut seen, mut computed, mut matter) = (0, 0, [0; COMPUTED.len()], Vec::new());
    let has_cells = |scene: &Scene| {
        let straight = scene.effect.ray_path == RayPath::Straight;
        straight && scene.slots(&library)["cells"] == ["grid"]
    };
    let presets = names().map(|name| {
        let mut scene = preset(name).unwrap();
        scene.quality.pass = Pass::March;
        scene.object.resolution = scene.object.resolution.min(48);
        (name, scene)
    });
    let presets: Vec<_> = presets.filter(|(_, scene)| has_cells(scene)).collect();
    assert!(presets.len() > 15, "{}", presets.len());
    for index in 0..presets.len() + count {
        let (name, mut scene) = presets[index % presets.len()].clone();
        // Every other scene after the presets computes its noise.
        if index >= presets.len() && index % 2 == 0 {
            let of = index / 2 % COMPUTED.len();
            computed[of] += usize::from(compute_noise(&mut scene, &library, COMPUTED[of]));
        }
        if index >= presets.len() {
            let all: Vec<(String, [f32; 2])> = (Variant::of(&scene, &library).unwrap().all_parameters())
                .filter_map(|(name, parameter, _)| match parameter.kind {
                    ParameterKind::Number(_, range) => Some((name, range)),
                    ParameterKind::Color(_) => None,
                })
                .collect();
            for (name, [low, high]) in all {
                let (mut other, value) = (scene.clone(), low + (high - low) * random.unit() as f32);
                let key = match name.rsplit_once('.') {
                    Some((part, own)) => format!("{part}.parameters.{own}"),
                    None => format!("parameters.{name}"),
                };
                let takes = random.bits().is_multiple_of(2) && other.set_field(&key, &value.to_string()).is_ok();
                if takes && other.check(&library).is_ok() {
                    scene = other;
                }
            }
        }
        let (empty, wrong) = judge(&scene, 16, &mut random, samples);
        println!("{name}: {empty} of 4096 cells are empty");
        (cells, seen) = (cells + empty, seen + if empty > 0 { samples } else { 0 });
        // A cube fills its box.
        assert!(empty > 0 || index >= presets.len() || name == "eroded_cube", "{name}");
        if wrong > 0 {
            matter.push(format!("{index} {name}: {wrong} samples, {:?}", scene.parameters));
        }
    }
    println!("{cells} cells of {} scenes, {computed:?} of computed noise, {seen} samples", presets.len() + count);
    assert!(computed.iter().sum::<usize>() > 1, "{computed:?}");
    assert!(cells > 20_000, "{cells}");
    assert!(matter.is_empty(), "{}", matter.join("\n"));
}

#[test]
fn m61_tiles_cover_cells_with_matter_and_few_others() {
    let library = shader::shipped();
    let mut random = SplitMix(39);
    let changes: [fn(&mut Scene); 5] = [
        |_| (),
        |scene| scene.quality.order = Order::BackToFront,
        |scene| scene.camera.projection = Projection::Parallel,
        |scene| scene.quality.pass = Pass::March,
        |scene| (scene.camera.zoom, scene.camera.pan) = (4.0, [0.3, -0.2]),
    ];
    for change in changes {
        let mut scene = preset("lit").unwrap();
        scene.object.input = "sphere".into();
        (scene.quality.pass, scene.quality.samples, scene.image.size) = (Pass::Slices, 200, [300, 200]);
        (scene.camera.azimuth, scene.camera.elevation) = (130.0, 40.0);
        change(&mut scene);
        let frame = context(&scene, &library);
        let (side, view, planes) = (16, &frame.view, frame.planes);
        let boxes = CellGrid::of(&frame, side);
        // A ball of cells in a corner.
        let away =
            |index: u32| [index % side, index / side % side, index / side / side].map(|at| (at as f32 - 4.0).powi(2));
        let empty: Vec<bool> = (0..side.pow(3)).map(|index| away(index).iter().sum::<f32>() > 9.0).collect();
        let whole = [Area::whole(scene.image.size)];
        let tiles = slice_tiles::tiles(&frame, &boxes, &empty, &whole);
        let part = tiles.pixels(0..planes.count) as f64 / (whole[0].pixels() * u64::from(planes.count)) as f64;
        assert!(part > 0.0 && part < 0.3, "{part}");
        let full: Vec<u32> = (0..side.pow(3)).filter(|&index| !empty[index as usize]).collect();
        for _ in 0..20_000 {
            let index = full[(random.bits() % full.len() as u64) as usize];
            let cell = boxes.cell([index % side, index / side % side, index / side / side], side);
            let [x, y, z, _] = cell.map(|range| (range.lo + (range.hi - range.lo) * random.unit()) as f32);
            let eye = view.object_matrix.transform_point3(glam::Vec3::new(x, y, z));
            // The pixel whose ray in `march.frag` meets the place.
            let depth = if scene.camera.projection == Projection::Perspective { -eye.z } else { 1.0 };
            let place = [0, 1].map(|axis| {
                let sign = if axis == 0 { 1.0 } else { -1.0 };
                let at = sign * eye[axis] / (view.ray_scale[axis] * depth) + view.pan[axis];
                (0.5 * (at + 1.0) * scene.image.size[axis] as f32).floor()
            });
            let plane = ((-eye.z - planes.first_depth) / planes.step).round();
            let [width, height] = scene.image.size.map(|side| side as f32);
            let is_seen = (0.0..width).contains(&place[0]) && (0.0..height).contains(&place[1]);
            if !is_seen || !(0.0..planes.count as f32).contains(&plane) {
                continue;
            }
            let slice = match scene.quality.order {
                Order::FrontToBack => plane as u32,
                Order::BackToFront => planes.count - 1 - plane as u32,
            };
            let [column, row] = place.map(|at| at as u32);
            let drawn = tiles.runs(slice..slice + 1).flat_map(|(_, areas)| areas);
            let count = drawn.filter(|area| area.columns.contains(&column) && area.rows.contains(&row)).count();
            assert_eq!(count, 1, "{place:?} in slice {slice}");
        }
    }
}
