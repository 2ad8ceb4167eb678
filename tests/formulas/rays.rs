//! Geometry of rays and slices.

use crate::formulas::harness::{At, Check};
use crate::formulas::knots::pcg3d;
use crate::formulas::values::c;
use glam::{DMat3, DMat4, DVec2, DVec3};
use hypertexture::shader::Library;

crate::rows! {
    m02_parallel_rays_cross_slices_at_a_right_angle = |l| projection(l, "parallel", |at| {
        let [x, y, depth, _] = at.p[0];
        let scale = at.vector("ray_scale");
        (DVec3::new(x * scale.x, -y * scale.y, -depth), DVec3::Z)
    }),
        "projection/parallel.glsl": "-ndc.y" => "ndc.y",
        "projection/parallel.glsl": "vec3(0.0, 1.0, 0.0))" => "vec3(0.0, -1.0, 0.0))";
    p37_rays_in_perspective_meet_in_the_eye = |l| projection(l, "perspective", |at| {
        let [x, y, depth, _] = at.p[0];
        let scale = at.vector("ray_scale");
        (depth * DVec3::new(x * scale.x, -y * scale.y, -1.0), -at.place(3).normalize())
    }),
        "projection/perspective.glsl": "ray_scale.x * depth" => "ray_scale.x",
        "projection/perspective.glsl": "length(position_eye) / max" => "max",
        "projection/perspective.glsl": "cross(side, along)" => "cross(along, side)";
    m64_a_plane_clips_points_and_segments = plane,
        "clip/plane.glsl": "clip_plane.w + sample_reach" => "clip_plane.w - sample_reach",
        "clip/plane.glsl": "-over / rise" => "over / rise",
        "clip/plane.glsl": "1.5 * step_size" => "0.5 * step_size";
    m64_nothing_is_clipped_without_a_plane = unclipped,
        "clip/none.glsl": "vec2(0.0, 1.0)" => "vec2(0.0, 0.5)";
    p38_every_sample_is_taken = |l| advances(l, "sample"),
        "empty_space/sample.glsl": "1.0" => "2.0";
    m61_p50_rays_leap_by_whole_steps = |l| advances(l, "leap"),
        "empty_space/leap.glsl": "floor(distance_bound" => "ceil(distance_bound";
    m61_p50_rays_that_find_first_leap_alike = |l| advances(l, "skip"),
        "empty_space/skip.glsl": "empty_space/leap.glsl" => "empty_space/sample.glsl";
    p48_a_hash_of_the_pixel_is_the_phase_of_its_steps = jittered,
        "jitter/hash.glsl": "- 0.5" => "- 0.25",
        "shift_sample.glsl": "-sample_phase()" => "sample_phase()";
    p48_a_tile_of_blue_noise_is_the_phase_of_its_steps = blue,
        "jitter/blue.glsl": "r + jitter_seed" => "r - jitter_seed";
    m30_a_fragment_without_matter_is_rejected_or_kept = rejected,
        "reject/discard.glsl": "discard; }" => "matter = vec4(0.0); }",
        "reject/keep.glsl": "matter = vec4(0.0)" => "discard";
    p48_without_jitter_samples_stay = still,
        "jitter/none.glsl": "return 0.0" => "return 0.5";
    p37_a_ray_enters_and_leaves_the_box_and_the_ball = crossings,
        "box_intersection.glsl": "box_min.xyz - sample_reach" => "box_min.xyz + sample_reach",
        "box_intersection.glsl": "nearest + half_chord" => "nearest - half_chord";
    m29_slice_samples_lie_on_the_rays_of_their_pixels = placed,
        "on_ray.glsl": "- before) / along" => "+ before) / along",
        "on_ray.glsl": "+ picture_scale.zw" => "- picture_scale.zw";
    m29_a_sample_of_a_stack_is_where_its_vertices_say = stacked,
        "sampling/stack.glsl": "x = x_in" => "x = position_eye_in";
    g11_a_slice_is_cut_to_the_box = polygons,
        "proxy/polygons.glsl": "edge[c] * (past / rise[c])" => "edge[b] * (past / rise[c])",
        "proxy/polygons.glsl": "box_max.xyz + box_margin" => "box_max.xyz";
    m01_a_quad_stays_where_it_is = quads,
        "proxy/quads.glsl": "return position" => "return -position";
}

/// A place on a ray, the direction to the eye, the path from slice to slice, the basis of the ray, the size of a pixel.
fn projection(library: &Library, module: &str, formula: fn(&At<'_>) -> (DVec3, DVec3)) -> f64 {
    let text = "void check() {
            out0 = vec4(ray_at(p0.xy, p0.z), path_scale());
            out1.xyz = to_eye();
            // A basis: along the ray, orthonormal, of one hand.
            mat3 b = ray_basis, g = transpose(b) * b - mat3(1.0);
            float off = dot(g[0], g[0]) + dot(g[1], g[1]) + dot(g[2], g[2]);
            out1.w = pixel_width() * (1.0 + off + length(b[0] + to_eye()) + abs(determinant(b) + 1.0));
        }";
    Check::new(library, &[("projection", module)], text).holds(1e-9, |at| {
        let (place, to_eye) = formula(at);
        // The slices are planes of z; a ray goes through one spacing of them in 1 / cos.
        let pixel = at.vector("ray_scale").y * at.vector("picture_scale").y;
        let deep = if module == "parallel" { 1.0 } else { -at.place(3).z };
        let path = 1.0 / to_eye.z;
        [place.to_array().as_slice(), &[path], &to_eye.to_array(), &[pixel * deep]].concat()
    })
}

/// Rest of a segment: its points on the kept side, by bisection against the plane.
fn plane(library: &Library) -> f64 {
    let text = "#include <clip>\nvoid check() {
            out0 = vec4(clipped(p0.xyz) ? 1.0 : 0.0, kept(p0.xyz, p1.xyz), 0.0);
            out1.xyz = cap_normal(p0.xyz, p2.xyz);
        }";
    let check = Check::new(library, &[("clip", "plane")], text).given(|random, setting| {
        let mut p = random.point();
        if random.unit() < 0.5 {
            // Near to the plane.
            let normal = setting.vector("clip_plane");
            let x = random.in_cube(1.0);
            let away = normal.dot(x) / normal.length_squared() - setting.fourth("clip_plane");
            p[0] = (x - normal * (away + random.within(-0.2, 0.2))).extend(0.0).to_array();
        }
        p[1] = random.in_cube(0.3).extend(0.0).to_array();
        p
    });
    check.holds(1e-9, |at| {
        let (normal, offset) = (at.vector("clip_plane"), at.fourth("clip_plane"));
        let over = |x: DVec3| normal.dot(x) - offset;
        let (from, to) = (at.place(0), at.place(0) + at.place(1));
        let crossing = over(from) / (over(from) - over(to));
        let kept = match (over(from) > 0.0, over(to) > 0.0) {
            (false, false) => [0.0, 1.0],
            (false, true) => [0.0, crossing],
            (true, false) => [crossing, 1.0],
            (true, true) if over(to) < over(from) => [1.0, 0.0],
            (true, true) => [0.0, -1.0],
        };
        let clipped = f64::from(over(from) > at.number("sample_reach"));
        let cap = if over(from) > -1.5 * at.number("step_size") { normal } else { at.place(2) };
        [&[clipped], kept.as_slice(), &[0.0], &cap.to_array()].concat()
    })
}

fn unclipped(library: &Library) -> f64 {
    let text = "#include <clip>\nvoid check() {
            out0 = vec4(clipped(p0.xyz) ? 1.0 : 0.0, kept(p0.xyz, p1.xyz), 0.0);
            out1.xyz = cap_normal(p0.xyz, p2.xyz);
        }";
    Check::new(library, &[], text).holds(1e-12, |at| [[0.0, 0.0, 1.0, 0.0].as_slice(), &at.p[2][..3]].concat())
}

/// The largest number of whole steps that does not exceed the distance_bound, and at least one.
fn advances(library: &Library, module: &str) -> f64 {
    let text = "#include \"distance_bound.glsl\"\n#include <empty_space>
        void check() { distance_bound = p0.x; out0.x = advance(p0.y); }";
    let check = Check::new(library, &[("empty_space", module)], text)
        .given(|random, _| [[random.coordinate(), random.within(0.004, 0.2), 0.0, 0.0]; 4]);
    check.worst(|at, found| {
        let [distance_bound, step, ..] = at.p[0];
        let steps = found[0];
        let right = match module {
            "skip" | "leap" => {
                steps.fract() == 0.0
                    && steps >= 1.0
                    && (steps == 1.0 || steps * step <= distance_bound)
                    && (steps + 1.0) * step > distance_bound
            }
            _ => steps == 1.0,
        };
        if right { 0.0 } else { f64::INFINITY }
    })
}

const JITTER: &str = "#include \"hash.glsl\"\n#include <jitter>\nvoid check() {
        vec3 eye = p3.xyz, x = p0.xyz;
        shift_sample(eye, x);
        out0 = vec4(eye, sample_phase());
        out1.xyz = x;
    }";

fn jittered(library: &Library) -> f64 {
    let wide = [("box_min", [-9.0; 3]), ("box_max", [9.0; 3])];
    let check = Check::new(library, &[("jitter", "hash")], JITTER).given(|random, _| {
        let mut p = random.point();
        p[0] = random.in_cube(2.0).extend(0.0).to_array();
        p
    });
    let seen = std::cell::Cell::new(0usize);
    wide.iter().fold(check, |check, (name, value)| check.with(name, value)).holds(1e-9, |at| {
        // Points go row by row over 64 pixels.
        let pixel = seen.get() % 320;
        seen.set(seen.get() + 1);
        let word = pcg3d([pixel as u32 % 64, pixel as u32 / 64, at.number("jitter_seed") as u32])[0];
        let phase = f64::from(word >> 8) / 16_777_216.0 - 0.5;
        let eye = at.place(3);
        // Away from the eye by the phase of a step.
        let path = at.number("step_size") * eye.length() / -eye.z;
        let shift = eye.normalize() * phase * path;
        let x = at.place(0) + DMat3::from_mat4(at.matrix("texture_matrix")) * shift;
        [(eye + shift).to_array().as_slice(), &[phase], &x.to_array()].concat()
    })
}

/// The phase of a tile, which the seed turns; points go row by row over 64 pixels.
fn blue(library: &Library) -> f64 {
    let seen = std::cell::Cell::new(0usize);
    let text = "#include <jitter>\nvoid check() { out0.x = sample_phase(); }";
    Check::new(library, &[("jitter", "blue")], text).holds(1e-9, |at| {
        let pixel = seen.get() % 320;
        seen.set(seen.get() + 1);
        let tile = at.texture("phase_image").texels[pixel / 64 % 8 * 8 + pixel % 8][0];
        vec![(f64::from(tile) + at.number("jitter_seed") / 16_777_216.0).rem_euclid(1.0) - 0.5]
    })
}

/// Discarded fragments write nothing; kept ones write empty matter.
fn rejected(library: &Library) -> f64 {
    let worst = ["discard", "keep"].map(|module| {
        let text = "#include <reject>\nvoid check() { out0 = p0; reject(out0); out1.x = 1.0; }";
        let kept = f64::from(module == "keep");
        Check::new(library, &[("reject", module)], text).holds(1e-9, move |_| vec![0.0, 0.0, 0.0, 0.0, kept])
    });
    worst[0].max(worst[1])
}

fn still(library: &Library) -> f64 {
    Check::new(library, &[], JITTER).holds(1e-12, |at| [&at.p[3][..3], &[0.0], &at.p[0][..3]].concat())
}

/// Where on a ray all six half spaces, and the ball, hold it.
fn crossings(library: &Library) -> f64 {
    let text = "#include \"box_intersection.glsl\"
        void check() { out0.xy = intersect_box(p0.xyz, p1.xyz); out0.zw = ball_crossing(p0.xyz, p1.xyz); }";
    let check = Check::new(library, &[], text).with("soft_radius", &[1.5]).given(|random, _| {
        let mut p = random.point();
        p[0] = random.in_cube(2.0).extend(0.0).to_array();
        p[1] = random.direction().extend(0.0).to_array();
        p
    });
    check.holds(1e-7, |at| {
        let (from, along, reach) = (at.place(0), at.place(1), at.number("sample_reach"));
        let (low, high) = (at.vector("box_min") - reach, at.vector("box_max") + reach);
        let (mut first, mut last) = (f64::NEG_INFINITY, f64::INFINITY);
        for axis in 0..3 {
            let (enter, leave) = if along[axis] > 0.0 { (low, high) } else { (high, low) };
            first = first.max((enter[axis] - from[axis]) / along[axis]);
            last = last.min((leave[axis] - from[axis]) / along[axis]);
        }
        // |from + t along|^2 = r^2.
        let (a, b) = (along.length_squared(), from.dot(along));
        let square = b * b - a * (from.length_squared() - (1.5 + reach).powi(2));
        let ball = if square > 0.0 { square.sqrt() / a } else { -1.0 };
        vec![first, last, -b / a - ball, -b / a + ball]
    })
}

/// The place of a plane, through a point of it, where a ray through a place beside the center of a pixel crosses it.
fn placed(library: &Library) -> f64 {
    let text = "#define position_eye_in p3.xyz\n#include \"on_ray.glsl\"
        void check() { vec3 eye, x; place(eye, x); out0.xyz = eye; out1.xyz = x; }";
    let slots = [("perspective", "facing"), ("perspective", "half_angle"), ("parallel", "half_angle")];
    let worst = slots.map(|(projection, planes)| {
        let seen = std::cell::Cell::new(0u32);
        Check::new(library, &[("projection", projection), ("planes", planes)], text).holds(1e-9, move |at| {
            // Points go row by row over 64 pixels.
            let pixel = DVec2::new(f64::from(seen.get() % 320 % 64), f64::from(seen.get() % 320 / 64)) + 0.5;
            seen.set(seen.get() + 1);
            let (width, beside) = (at.vector("picture_scale"), at.fourth("picture_scale"));
            let ndc = DVec2::new(pixel.x * width.x - 1.0 + width.z, pixel.y * width.y - 1.0 + beside);
            let (scale, normal) = (at.vector("ray_scale"), at.vector("slice_axis"));
            let normal = if planes == "facing" { DVec3::Z } else { normal };
            let aside = DVec3::new(ndc.x * scale.x, -ndc.y * scale.y, 0.0);
            let (from, along) =
                if projection == "parallel" { (aside, -DVec3::Z) } else { (DVec3::ZERO, aside - DVec3::Z) };
            let eye = from + along * (normal.dot(at.place(3) - from) / normal.dot(along));
            let x = at.matrix("texture_matrix").transform_point3(eye);
            [eye.to_array().as_slice(), &[0.0], &x.to_array()].concat()
        })
    });
    worst.into_iter().fold(0.0, f64::max)
}

fn stacked(library: &Library) -> f64 {
    let text = "#define position_eye_in p3.xyz\n#define x_in p0.xyz\n#include \"checked.glsl\"
        void check() { vec3 eye, x; place(eye, x); out0.xyz = eye; out1.xyz = x; }";
    Check::new(&without_layout(library, "sampling/stack.glsl"), &[], text)
        .holds(1e-12, |at| [&at.p[3][..3], &[0.0], &at.p[0][..3]].concat())
}

/// With a file `checked.glsl`: one without its inputs.
fn without_layout(library: &Library, path: &str) -> Library {
    let own = library.source(path).unwrap();
    let own = own.lines().filter(|line| !line.starts_with("layout")).collect::<Vec<_>>().join("\n");
    Library::new(
        library.sources().map(|(path, text)| (path.into(), text.into())).chain([("checked.glsl".to_string(), own)]),
    )
}

/// The twelve edges of the box where a plane of z cuts them, eye space.
fn cuts(object: DMat4, low: DVec3, high: DVec3, z: f64) -> Vec<DVec3> {
    let corner = |index: usize| {
        let side = DVec3::from_array([0, 1, 2].map(|axis| f64::from((index >> axis & 1) as u8)));
        object.transform_point3(low + (high - low) * side)
    };
    let edges =
        (0..8).flat_map(|from| (0..3).map(move |axis| (from, from | 1 << axis))).filter(|(from, to)| from != to);
    let ends = edges.map(|(from, to)| (corner(from), corner(to)));
    ends.filter(|(a, b)| (a.z - z) * (b.z - z) < 0.0).map(|(a, b)| a + (b - a) * ((z - a.z) / (b.z - a.z))).collect()
}

fn area(corners: &[DVec3]) -> f64 {
    let cross = |a: DVec3, b: DVec3| a.truncate().perp_dot(b.truncate());
    let around = (0..corners.len()).map(|i| cross(corners[i], corners[(i + 1) % corners.len()]));
    around.sum::<f64>().abs() / 2.0
}

/// Six corners in order are the polygon in which a slice cuts the box: those of the edges, of the same area.
fn polygons(library: &Library) -> f64 {
    let text = "#define corner vec2(p0.xy)\n#define material p1\n#include \"checked.glsl\"\nvoid check() { out0.xyz = proxy_position(); }";
    // The inputs of the vertex stage are those of the check.
    let own = library.source("proxy/polygons.glsl").unwrap();
    let inputs = |line: &&str| !line.starts_with("layout");
    let own = own.lines().filter(inputs).collect::<Vec<_>>().join("\n");
    let library = Library::new(
        library.sources().map(|(path, text)| (path.into(), text.into())).chain([("checked.glsl".to_string(), own)]),
    );
    let check = Check::new(&library, &[], text);
    let counter = std::cell::Cell::new((0usize, 0.0));
    let check = check.given(move |random, setting| {
        // Six points share a slice, which cuts the box.
        let (index, mut z) = counter.get();
        if index % 6 == 0 {
            z = setting.matrix("object_matrix").w_axis.z + random.within(-0.9, 0.9);
        }
        counter.set((index + 1, z));
        [[(index % 6) as f64, z, 0.0, 0.0], [0.0; 4], [0.0; 4], [0.0, 0.0, -1.0, 0.0]]
    });
    let worst = check.each(|setting, results| {
        let margin = setting.number("box_margin");
        let (low, high) = (setting.vector("box_min") - margin, setting.vector("box_max") + margin);
        let mut worst = 0.0f64;
        let start = results.iter().position(|(at, _)| at.p[0][0] == 0.0).unwrap();
        for six in results[start..].chunks_exact(6) {
            let found: Vec<DVec3> = six.iter().map(|(_, found)| DVec3::from_slice(found)).collect();
            let expected = cuts(setting.matrix("object_matrix"), low, high, six[0].0.p[0][1]);
            let nearest = |p: &DVec3| expected.iter().map(|q| q.distance(*p)).fold(f64::INFINITY, f64::min);
            let center = expected.iter().sum::<DVec3>() / expected.len() as f64;
            let mut ordered = expected.clone();
            let angle = |p: &DVec3| DVec2::new(p.x - center.x, p.y - center.y).to_angle();
            ordered.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
            let off = found.iter().map(nearest).fold(0.0, f64::max);
            worst = worst.max(off).max((area(&found) - area(&ordered)).abs());
        }
        worst / 1e-6
    });
    worst.fold(0.0, f64::max)
}

fn quads(library: &Library) -> f64 {
    let text = "#define position p0.xyz\n#define tex_coord p1.xyz\n#define material p2\n#include \"checked.glsl\"
        void check() { out0.xyz = proxy_position() + proxy_tex_coord(); out1 = proxy_color(); }";
    Check::new(&without_layout(library, "proxy/quads.glsl"), &[], text).holds(1e-12, |at| {
        let sum = at.place(0) + at.place(1);
        [sum.to_array().as_slice(), &[c(0.0)], &at.p[2]].concat()
    })
}
