//! Declarations of modules and claims of their sources, proved by their own programs in f64 at random points.

use crate::probe::Probe;
use glam::DVec3;
use hypertexture::eval::{Inputs, Invocations};
use hypertexture::render::variant::{Use, Variant};
use hypertexture::scene::{ParameterValue, Projection, Scene, preset};
use hypertexture::shader::{self, ParameterKind};
use hypertexture_support::random::SplitMix;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

const HEAD: &str = "#version 450\n#include \"interface.glsl\"\n#include \"vector.glsl\"\n\
                    layout(location = 0) out vec4 fragment;\nPOINT\n";

/// Points of each set of parameters.
const POINTS: usize = 1200;
const SETS: usize = 8;

fn direction(random: &mut SplitMix) -> DVec3 {
    let (z, angle) = (2.0 * random.unit() - 1.0, TAU * random.unit());
    let r = (1.0 - z * z).sqrt();
    DVec3::new(r * angle.cos(), r * angle.sin(), z)
}

fn run(probe: &Probe, inputs: &Inputs, varyings: BTreeMap<u32, Vec<[f64; 4]>>) -> Vec<DVec3> {
    let fragment_coordinates = vec![[0.5, 0.5, 0.5, 1.0]; varyings[&0].len()];
    let lanes = Invocations { fragment_coordinates, varyings };
    let out = probe.program().bind(inputs).unwrap().run::<f64>(&lanes).unwrap();
    out[&0].iter().map(|v| DVec3::new(v[0], v[1], v[2])).collect()
}

fn lanes(points: &[DVec3]) -> Vec<[f64; 4]> {
    points.iter().map(|p| [p.x, p.y, p.z, 1.0]).collect()
}

/// A scene of a stack of warps with random parameters.
fn warped(stack: &[&str], random: &mut SplitMix) -> Scene {
    let mut scene = preset("noisy_sphere").unwrap();
    scene.parameters.clear();
    scene.effect.warp = stack.iter().map(|name| name.to_string()).collect();
    (scene.effect.noise, scene.effect.turbulence) = ("procedural".into(), "procedural".into());
    let parameters = Variant::of(&scene, &shader::shipped()).unwrap().parameters;
    for (parameter, _) in parameters.iter() {
        if let ParameterKind::Number(_, [low, high]) = parameter.kind {
            let high =
                if parameter.name.contains("frequency") || parameter.name.contains("drips") { 4.0 } else { high };
            let value = f64::from(low) + random.unit() * f64::from(high - low);
            scene.parameters.insert(parameter.name.clone(), ParameterValue::Number(value as f32));
        }
    }
    scene
}

#[test]
fn p24_warps_move_lookups_and_matter_within_their_bounds() {
    let library = shader::shipped();
    let text = format!(
        "{HEAD}#include <warp>\nvoid main() {{\n    vec3 x = point().xyz;\n    mat3 jacobian = mat3(1.0);\n    \
         displace(x, jacobian);\n    fragment = vec4(x, 1.0);\n}}\n"
    );
    let mut stacks: Vec<Vec<&str>> = library.modules("warp").into_iter().map(|name| vec![name]).collect();
    stacks.extend([vec!["noisy", "melting"], vec!["turbulent", "perturbed"], vec!["dripping", "fractal", "noisy"]]);
    let mut random = SplitMix(11);
    let mut count = 0;
    for stack in &stacks {
        let (mut used, mut grown) = (0f64, 0f64);
        for _ in 0..SETS {
            let scene = warped(stack, &mut random);
            let parameters = Variant::of(&scene, &library).unwrap().parameters;
            // The object: what a box and a ball have in common.
            let radius = 0.6 + random.unit();
            let half = DVec3::new(random.unit(), random.unit(), random.unit()) * radius;
            let spread = parameters.spread(radius as f32, 1.0);
            let (grows, moves) = (spread.grows, spread.moves);
            let own_radius = radius + f64::from(grows.farthest());
            let sides = |round: f32, side: [f32; 3]| DVec3::from(side.map(|length| f64::from(round + length)));
            let (low, high) = (-half - sides(grows.round, grows.low), half + sides(grows.round, grows.high));
            let points: Vec<DVec3> = (0..POINTS)
                .map(|index| {
                    let along = direction(&mut random);
                    // Within three radii; and a little beyond the ball and the box that hold what has grown.
                    let box_at = (along / (if index % 2 == 0 { high } else { low })).max_element();
                    match index % 3 {
                        0 => along * (3.0 * radius * random.unit()),
                        1 => along * (own_radius * (1.0 + 0.2 * random.unit() * random.unit())),
                        _ => along / box_at * (1.0 + 0.2 * random.unit() * random.unit()),
                    }
                })
                .collect();
            let mut probe = Probe::new(&library, &text, &scene.slots(&library), "warp", true).unwrap();
            for resource in &probe.linked.resources {
                let Use::Block(block) = &resource.holds else { continue };
                let values: BTreeMap<String, Vec<f32>> = (block.members.iter())
                    .map(|member| {
                        let number = parameters.iter().find(|(parameter, _)| parameter.name == member.name);
                        let value = match (number, member.name.as_str()) {
                            (Some((_, ParameterValue::Number(number))), _) => *number,
                            (_, "hold_radius") => spread.hold_radius,
                            (_, "own_radius") => own_radius as f32 * 1.000_001,
                            (_, "noise_period" | "turbulence_period") => 256.0,
                            (_, "turbulence_growth" | "turbulence_cycle") => 1.0,
                            (_, "sample_reach") => 0.0, // a turbulence may end early
                            (_, "time") => 1.5,
                            _ => 0.5,
                        };
                        (member.name.clone(), vec![value; member.floats])
                    })
                    .collect();
                let filled = block.fill(|name| values.get(name).map(Vec::as_slice)).unwrap();
                probe.inputs.blocks.insert(resource.binding, filled);
            }
            let found = run(&probe, &probe.inputs, [(0, lanes(&points))].into());
            for (x, y) in points.iter().zip(found) {
                let step = y - *x;
                let along = step.clamp(-sides(0.0, moves.low), sides(0.0, moves.high));
                let round = f64::from(moves.round) * (1.0 + 1e-6) + 1e-6;
                assert!((step - along).length() <= round, "{stack:?}: {x} to {y}, {spread:?}, {:?}", scene.parameters);
                used = used.max(step.length() / f64::from(moves.farthest()).max(1e-6));
                if y.abs().cmple(half).all() && y.length() <= radius {
                    let inside = x.cmpge(low - 1e-6).all() && x.cmple(high + 1e-6).all();
                    let near = x.length() <= own_radius * (1.0 + 1e-6);
                    assert!(inside && near, "{stack:?}: matter at {x}, of {y}, {spread:?}, {:?}", scene.parameters);
                    assert!(
                        spread.held || x.length() <= f64::from(spread.hold_radius) * (1.0 + 1e-6),
                        "{stack:?}: {x}"
                    );
                    grown = grown.max((x.abs() - half).max_element().max(x.length() - radius));
                }
                count += 1;
            }
        }
        println!("{stack:?}: {used:.2} of the declared move, matter grows by {grown:.2}");
        assert!(used > 0.2 && used <= 1.000_001, "{stack:?}: {used}");
    }
    assert!(count >= 90_000, "{count} points");
}

/// The largest v . r(l) over all normals of a cylinder around t, by search: r mirrors l at the normal.
fn brightest(t: DVec3, l: DVec3, v: DVec3) -> f64 {
    let a = t.any_orthonormal_vector();
    let b = t.cross(a);
    let seen = |angle: f64| {
        let n = angle.cos() * a + angle.sin() * b;
        v.dot(2.0 * n.dot(l) * n - l)
    };
    const TURNS: u32 = 64;
    let coarse = (0..TURNS).map(|k| TAU * f64::from(k) / f64::from(TURNS)).max_by(|p, q| seen(*p).total_cmp(&seen(*q)));
    let (mut low, mut high) = (coarse.unwrap() - TAU / f64::from(TURNS), coarse.unwrap() + TAU / f64::from(TURNS));
    for _ in 0..60 {
        let (p, q) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if seen(p) < seen(q) { low = p } else { high = q }
    }
    seen(0.5 * (low + high))
}

#[test]
fn p56_the_highlight_of_hair_is_the_mirror_cone_of_a_cylinder() {
    let text = format!(
        "{HEAD}layout(location = 1) in vec4 tangent;\nvec3 position_eye;\nvec4 color = vec4(0.0);\n#include <projection>\n\
         #include \"sample_point.glsl\"\n#include <medium>\nvoid main() {{\n    \
         position_eye = light_position.xyz - 4.0 * point().xyz;\n    \
         Sample s;\n    s.density = 0.0;\n    s.hair_normal = point().xyz;\n    s.hair_tangent = tangent.xyz;\n    \
         fragment = vec4(medium(s, 0.5), 1.0);\n}}\n"
    );
    let mut scene = preset("furry_donut").unwrap();
    scene.camera.projection = Projection::Parallel;
    scene.light.shadows = false;
    let probe = Probe::new(&shader::shipped(), &text, &scene.slots(&shader::shipped()), "medium", true).unwrap();
    let mut random = SplitMix(5);
    let (lights, tangents): (Vec<DVec3>, Vec<DVec3>) =
        (0..10_000).map(|_| (direction(&mut random), direction(&mut random))).unzip();
    let found = run(&probe, &probe.inputs, [(0, lanes(&lights)), (1, lanes(&tangents))].into());
    // Of the probe: the sheen, the light and the power; the eye is far away along z.
    let (strength, power) = (0.25 * 0.75, 24);
    let mut bright = 0;
    for ((l, t), color) in lights.iter().zip(&tangents).zip(found) {
        let expected = strength * brightest(*t, *l, DVec3::Z).max(1e-4).powi(power);
        assert!((color.x - expected).abs() <= 1e-5, "light {l}, hair {t}: {} in place of {expected}", color.x);
        bright += u32::from(expected > 0.01);
    }
    assert!(bright > 500, "{bright}");
}
