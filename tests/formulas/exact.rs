//! The exact evaluator: operations against Rust's f64, control flow, images, and every program that ships.

use hypertexture::eval::{BoundProgram, Evaluate, Inputs, Interval, Invocations, Number, Program, Texture, Wrap};
use hypertexture::render::variant::{Purpose, Variant};
use hypertexture::scene::{self, Pass};
use hypertexture::shader::{self, Library, Linker, Slots, Stage};
use std::collections::BTreeMap;

/// A fragment stage whose output is computed by `body` from `x`, a vec4 that comes from the vertex stage.
pub fn program(before: &str, body: &str) -> Program {
    read(before, body).unwrap_or_else(|error| panic!("{error}"))
}

fn read(before: &str, body: &str) -> Result<Program, hypertexture::eval::ExactError> {
    let text = format!(
        "#version 450\nlayout(location = 0) in vec4 x;\nlayout(location = 0) out vec4 result;\n{before}\n\
         void main() {{\n{body}\n}}\n"
    );
    let library = Library::new([("test.frag".to_string(), text)]);
    let linker = Linker::new().unwrap_or_else(|error| panic!("{error}"));
    let spirv = linker.link(&library, "test.frag", Stage::Fragment, &["test.frag"], &Slots::new());
    Program::read(&spirv.unwrap_or_else(|error| panic!("{error}")), &[])
}

fn lanes<N: Evaluate>(values: &[[f64; 4]]) -> Invocations<N> {
    let values = values.iter().map(|value| value.map(N::new)).collect();
    Invocations { fragment_coordinates: Vec::new(), varyings: BTreeMap::from([(0, values)]) }
}

fn evaluate<N: Evaluate>(bound: &BoundProgram<'_>, values: &[[f64; 4]]) -> Vec<[N; 4]> {
    bound.run(&lanes(values)).unwrap_or_else(|error| panic!("{error}"))[&0].clone()
}

/// Points of the unit cube of four dimensions, evenly spread.
pub fn points(count: usize) -> Vec<[f64; 4]> {
    // Additive recurrence with the roots of x^5 = x + 1 (Roberts 2018).
    let root = 1.167_303_978_261_418_7_f64;
    (0..count).map(|n| [1, 2, 3, 4].map(|axis| ((n + 1) as f64 * root.powi(-axis)).fract())).collect()
}

/// Evaluates `body` in f64, and checks that intervals around and through the points hold its values.
pub fn both(before: &str, body: &str, inputs: &Inputs, values: &[[f64; 4]]) -> Vec<[f64; 4]> {
    let program = program(before, body);
    let bound = program.bind(inputs).unwrap_or_else(|error| panic!("{error}"));
    let found: Vec<[f64; 4]> = evaluate(&bound, values);
    let around: Vec<[Interval; 4]> = evaluate(&bound, values);
    for ((value, found), around) in values.iter().zip(&found).zip(&around) {
        for channel in 0..4 {
            let fits = around[channel].contains(found[channel]);
            assert!(fits, "{body}: {} at {value:?} is not in {:?}", found[channel], around[channel]);
        }
    }
    // Boxes from each point to the next, with points in them.
    for width in [1e-9, 1e-3, 0.3, 1.0] {
        let boxes: Vec<[Interval; 4]> = values
            .windows(2)
            .map(|pair| {
                [0, 1, 2, 3].map(|at| Interval::of(pair[0][at], pair[0][at] + width * (pair[1][at] - pair[0][at])))
            })
            .collect();
        let lanes = Invocations { fragment_coordinates: Vec::new(), varyings: BTreeMap::from([(0, boxes.clone())]) };
        let ranges = &bound.run(&lanes).unwrap_or_else(|error| panic!("{error}"))[&0];
        for part in points(8) {
            let inside: Vec<[f64; 4]> = boxes
                .iter()
                .map(|at| [0, 1, 2, 3].map(|k| (at[k].lo + part[k] * (at[k].hi - at[k].lo)).clamp(at[k].lo, at[k].hi)))
                .collect();
            for (at, (found, range)) in evaluate::<f64>(&bound, &inside).iter().zip(ranges).enumerate() {
                for channel in 0..4 {
                    let fits = range[channel].contains(found[channel]);
                    assert!(
                        fits,
                        "{body}: {} at {:?} of {:?} is not in {:?}",
                        found[channel], inside[at], boxes[at], range[channel]
                    );
                }
            }
        }
    }
    found
}

/// A GLSL body equals a function in Rust within some ulp of the largest intermediate number.
fn agrees(before: &str, body: &str, expected: impl Fn([f64; 4]) -> [f64; 4]) {
    let scaled = points(300).into_iter().map(|p| p.map(|t| 6.0 * t - 3.0));
    let special = [[0.0; 4], [1.0; 4], [-1.0; 4], [0.5, -0.5, 2.0, 0.0], [-0.0, 1.5, 2.5, -2.5]];
    let values: Vec<[f64; 4]> = scaled.chain(special).collect();
    for (value, found) in values.iter().zip(both(before, body, &Inputs::default(), &values)) {
        let expected = expected(*value);
        for channel in 0..4 {
            let (a, b) = (found[channel], expected[channel]);
            let same = a == b || a.is_nan() && b.is_nan() || (a - b).abs() <= 1e-13 * (1.0 + b.abs());
            assert!(same, "{body} at {value:?}: {found:?}, expected {expected:?}");
        }
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[test]
fn functions_of_one_number_are_those_of_rust() {
    type Of = fn(f64) -> f64;
    let functions: [(&str, Of); 27] = [
        ("-x", |x| -x),
        ("abs(x)", f64::abs),
        ("sign(x)", |x| if x == 0.0 { 0.0 } else { x.signum() }),
        ("floor(x)", f64::floor),
        ("ceil(x)", f64::ceil),
        ("trunc(x)", f64::trunc),
        ("roundEven(x)", f64::round_ties_even),
        ("fract(x)", |x| x - x.floor()),
        ("sqrt(x)", f64::sqrt),
        ("inversesqrt(x)", |x| 1.0 / x.sqrt()),
        ("exp(x)", f64::exp),
        ("exp2(x)", f64::exp2),
        ("log(x)", f64::ln),
        ("log2(x)", f64::log2),
        ("sin(x)", f64::sin),
        ("cos(x)", f64::cos),
        ("tan(x)", f64::tan),
        ("asin(x)", f64::asin),
        ("acos(x)", f64::acos),
        ("atan(x)", f64::atan),
        ("sinh(x)", f64::sinh),
        ("cosh(x)", f64::cosh),
        ("tanh(x)", f64::tanh),
        ("asinh(x)", f64::asinh),
        ("acosh(x)", f64::acosh),
        ("atanh(x)", f64::atanh),
        ("clamp(x, 0.0, 1.0)", |x| x.clamp(0.0, 1.0)),
    ];
    for (text, function) in functions {
        agrees("", &format!("result = {text};"), |x| x.map(function));
    }
}

#[test]
fn functions_of_several_numbers_are_their_definitions() {
    type Of = fn([f64; 4]) -> f64;
    let functions: [(&str, Of); 22] = [
        ("x.x + x.y", |x| x[0] + x[1]),
        ("x.x - x.y", |x| x[0] - x[1]),
        ("x.x * x.y", |x| x[0] * x[1]),
        ("x.x / x.y", |x| x[0] / x[1]),
        ("x.x * x.y + x.z", |x| x[0] * x[1] + x[2]),
        ("mod(x.x, x.y)", |x| x[0] - x[1] * (x[0] / x[1]).floor()),
        ("min(x.x, x.y)", |x| x[0].min(x[1])),
        ("max(x.x, x.y)", |x| x[0].max(x[1])),
        ("pow(abs(x.x), x.y)", |x| x[0].abs().powf(x[1])),
        ("atan(x.x, x.y)", |x| x[0].atan2(x[1])),
        ("step(x.x, x.y)", |x| if x[1] < x[0] { 0.0 } else { 1.0 }),
        ("mix(x.x, x.y, x.z)", |x| x[0] * (1.0 - x[2]) + x[1] * x[2]),
        ("smoothstep(-0.5, 0.75, x.x)", |x| {
            let t = ((x[0] + 0.5) / 1.25).clamp(0.0, 1.0);
            t * t * (3.0 - 2.0 * t)
        }),
        ("clamp(x.x, -abs(x.y), abs(x.z))", |x| x[0].max(-x[1].abs()).min(x[2].abs())),
        ("fma(x.x, x.y, x.z)", |x| x[0] * x[1] + x[2]),
        ("ldexp(x.x, int(x.y))", |x| x[0] * 2f64.powi(x[1] as i32)),
        ("radians(x.x)", f64_radians),
        ("degrees(x.x)", |x| x[0].to_degrees()),
        ("x.x < x.y ? x.z : x.w", |x| if x[0] < x[1] { x[2] } else { x[3] }),
        ("float(x.x >= x.y && x.z != x.w)", |x| f64::from(u8::from(x[0] >= x[1] && x[2] != x[3]))),
        ("float(x.x <= x.y ^^ x.z == x.w)", |x| f64::from(u8::from((x[0] <= x[1]) ^ (x[2] == x[3])))),
        ("float(any(lessThan(x.xy, x.zw)))", |x| f64::from(u8::from(x[0] < x[2] || x[1] < x[3]))),
    ];
    fn f64_radians(x: [f64; 4]) -> f64 {
        x[0].to_radians()
    }
    for (text, function) in functions {
        agrees("", &format!("result = vec4({text});"), |x| [function(x); 4]);
    }
}

#[test]
fn functions_of_vectors_and_matrices_are_their_definitions() {
    type Of = fn([f64; 3], f64) -> [f64; 4];
    let functions: [(&str, Of); 9] = [
        ("vec4(dot(v, n), length(v), distance(v, n), length(x.w))", |v, w| {
            let n = [0.6f32, 0.0, 0.8].map(f64::from);
            [dot(v, n), dot(v, v).sqrt(), (0..3).map(|i| (v[i] - n[i]).powi(2)).sum::<f64>().sqrt(), w.abs()]
        }),
        ("vec4(normalize(v), 0.0)", |v, _| {
            let length = dot(v, v).sqrt();
            [v[0] / length, v[1] / length, v[2] / length, 0.0]
        }),
        ("vec4(cross(v, n), 0.0)", |v, _| {
            let n = [0.6f32, 0.0, 0.8].map(f64::from);
            [v[1] * n[2] - v[2] * n[1], v[2] * n[0] - v[0] * n[2], v[0] * n[1] - v[1] * n[0], 0.0]
        }),
        ("vec4(reflect(v, n), 0.0)", |v, _| {
            let n = [0.6f32, 0.0, 0.8].map(f64::from);
            let d = 2.0 * dot(v, n);
            [v[0] - d * n[0], v[1] - d * n[1], v[2] - d * n[2], 0.0]
        }),
        ("vec4(faceforward(n, v, n), 0.0)", |v, _| {
            let n = [0.6f32, 0.0, 0.8].map(f64::from);
            let sign = if dot(n, v) < 0.0 { 1.0 } else { -1.0 };
            [sign * n[0], sign * n[1], sign * n[2], 0.0]
        }),
        ("vec4(refract(v, n, 0.7), 0.0)", |v, _| {
            let (n, eta) = ([0.6f32, 0.0, 0.8].map(f64::from), f64::from(0.7f32));
            let cosine = dot(n, v);
            let k = 1.0 - eta * eta * (1.0 - cosine * cosine);
            let along = eta * cosine + k.max(0.0).sqrt();
            let bent = [0, 1, 2].map(|i| if k < 0.0 { 0.0 } else { eta * v[i] - along * n[i] });
            [bent[0], bent[1], bent[2], 0.0]
        }),
        ("vec4(m * v, 0.0)", |v, w| [v[0] + w * v[2], 2.0 * v[1] + v[0], v[2] - v[1], 0.0]),
        ("vec4(v * m, 0.0)", |v, w| [v[0] + v[1], 2.0 * v[1] - v[2], w * v[0] + v[2], 0.0]),
        (
            "vec4(determinant(m), m[1][2], (m * inverse(m))[0][0] * 0.0 + determinant(transpose(m)), outerProduct(v, v)[2].x)",
            |v, w| {
                let determinant = 2.0 - w;
                [determinant, -1.0, determinant, v[0] * v[2]]
            },
        ),
    ];
    for (text, function) in functions {
        let body = format!(
            "vec3 v = x.xyz; const vec3 n = vec3(0.6, 0.0, 0.8);\n\
             mat3 m = mat3(1.0, 1.0, 0.0, 0.0, 2.0, -1.0, x.w, 0.0, 1.0);\nresult = {text};"
        );
        // The inverse is singular at w = 2, where the test has no point but a special one, and is taken times zero.
        agrees("", &body, |x| function([x[0], x[1], x[2]], x[3]));
    }
}

#[test]
fn integers_wrap_and_shift_as_on_the_gpu() {
    agrees(
        "",
        "int i = int(floor(x.x * 100.0)); uint u = uint(i) * 747796405u + 2891336453u; u ^= u >> 16u; \
                result = vec4(float(u), float(int(u) >> 3), float(u % 17u), float(i / 7 + (i & 255) - (i | 5) * 3));",
        |x| {
            let i = (x[0] * 100.0).floor() as i32;
            let mut u = (i as u32).wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            u ^= u >> 16;
            let last = (i / 7).wrapping_add(i & 255).wrapping_sub((i | 5).wrapping_mul(3));
            [f64::from(u), f64::from((u as i32) >> 3), f64::from(u % 17), f64::from(last)]
        },
    );
    agrees(
        "",
        "int i = int(x.x * 50.0); result = vec4(bitCount(i), findLSB(i), findMSB(uint(i)), float(min(i, -3) + max(abs(i), 4)) + float(i < 7) + intBitsToFloat(floatBitsToInt(x.y)) * 0.0);",
        |x| {
            let i = (x[0] * 50.0) as i32;
            let index = |zeros: u32, bit: u32| if zeros == 32 { -1.0 } else { f64::from(bit) };
            let u = i as u32;
            let high = index(u.leading_zeros(), 31u32.wrapping_sub(u.leading_zeros()));
            let last = i.min(-3) + i.abs().max(4) + i32::from(i < 7);
            [f64::from(i.count_ones()), index(i.trailing_zeros(), i.trailing_zeros()), high, f64::from(last)]
        },
    );
}

#[test]
fn lanes_go_their_own_ways_through_loops_branches_and_functions() {
    // Break, continue, a bound of its own in each lane, and an early return out of two loops.
    let before = "float walk(float x, inout float steps) {\n\
        float sum = 0.0;\n\
        for (int i = 0; i < 20; ++i) {\n\
            steps += 1.0;\n\
            if (i % 3 == 1) continue;\n\
            if (sum > 4.0) break;\n\
            for (int j = 0; j < i; ++j) {\n\
                sum += abs(x) * 0.1;\n\
                if (sum > 3.0 && x < 0.0) return -sum;\n\
            }\n\
            sum += 0.25;\n\
        }\n\
        return sum;\n\
    }";
    let walk = |x: f64| {
        let (mut sum, mut steps) = (0.0, 0.0);
        let tenth = f64::from(0.1f32);
        for i in 0..20 {
            steps += 1.0;
            if i % 3 == 1 {
                continue;
            }
            if sum > 4.0 {
                break;
            }
            for _ in 0..i {
                sum += x.abs() * tenth;
                if sum > 3.0 && x < 0.0 {
                    return [-sum, steps];
                }
            }
            sum += 0.25;
        }
        [sum, steps]
    };
    agrees(
        before,
        "float steps = 0.0; float sum = walk(x.x, steps); result = vec4(sum, steps, walk(x.y, steps), 0.0);",
        |x| {
            let ([sum, steps], [other, _]) = (walk(x[0]), walk(x[1]));
            [sum, steps, other, 0.0]
        },
    );
    let body = "float r = 0.0; switch (int(floor(x.x))) { case -2: r = x.y; break; case -1: r = x.z; case 0: r += 1.0; \
                break; case 2: if (x.y > 0.0) break; r = 5.0; default: r -= x.w; } result = vec4(r);";
    agrees("", body, |x| {
        [match x[0].floor() as i32 {
            -2 => x[1],
            -1 => x[2] + 1.0,
            0 => 1.0,
            2 if x[1] > 0.0 => 0.0,
            2 => 5.0 - x[3],
            _ => -x[3],
        }; 4]
    });
    agrees("", "if (x.x > 0.5) discard; result = vec4(1.0 + x.y);", |x| [if x[0] > 0.5 { 0.0 } else { 1.0 + x[1] }; 4]);
}

#[test]
fn short_branches_on_integers_are_what_their_sides_say() {
    // Values change places, one side writes, one branch is within another, the condition is written, a loop repeats it.
    let body = "uint h = uint(64.0 * x.x + 640.0) * 668265261u;
        float a = x.y, b = x.z;
        bool c = (h & 1u) != 0u;
        if (c) { float t = a; a = b; b = -t; }
        if ((h & 64u) == 0u) a = a * b + 1.0; else b -= a;
        if ((h & 128u) != 0u) { if ((h & 4096u) != 0u) b = -b; else a = -a; }
        if (c) { c = a < b; a *= 0.5; }
        float d = h < 0x55555555u ? a : (h < 0xaaaaaaaau ? b : x.w);
        for (uint k = 0u; k < 4u; ++k) {
            if (((h >> k) & 1u) != 0u) { d += a; a = -a; } else d *= 0.5;
        }
        result = vec4(a, b, c ? 1.0 : 0.0, d);";
    agrees("", body, |[x, y, z, w]| {
        let h = ((64.0 * x + 640.0) as u32).wrapping_mul(668_265_261);
        let (mut a, mut b, mut c) = (y, z, h & 1 != 0);
        if c {
            (a, b) = (b, -a);
        }
        match h & 64 == 0 {
            true => a = a * b + 1.0,
            false => b -= a,
        }
        match (h & 128 != 0, h & 4096 != 0) {
            (true, true) => b = -b,
            (true, false) => a = -a,
            (false, _) => {}
        }
        if c {
            c = a < b;
            a *= 0.5;
        }
        let mut d = match h {
            0..0x5555_5555 => a,
            0x5555_5555..0xaaaa_aaaa => b,
            _ => w,
        };
        for k in 0..4 {
            match h >> k & 1 != 0 {
                true => (d, a) = (d + a, -a),
                false => d *= 0.5,
            }
        }
        [a, b, f64::from(u8::from(c)), d]
    });
}

#[test]
fn arrays_and_structures_are_indexed_by_lanes() {
    let before = "struct Pair { vec2 a; float b[3]; };\nconst float TABLE[5] = float[](1.0, -2.0, 4.0, -8.0, 16.0);\n\
                  void change(inout Pair p, int at, float by) { p.b[at] = by; p.a[at & 1] += by; }";
    let body = "int i = int(floor(x.x + 3.0)) % 5; int j = abs(int(x.y)); Pair p; p.a = x.xy; p.b = float[](x.x, x.y, x.z);\n\
                change(p, j % 3, x.w); vec4 v = x; v[j] = 9.0;\n\
                mat2 m = mat2(x); m[i & 1][j & 1] = 7.0;\n\
                result = vec4(TABLE[i] + v[i & 3], p.b[0] + 2.0 * p.b[1] + 3.0 * p.b[2], p.a.x - p.a.y, m[0][0] + m[1][0] * m[0][1] - m[1][1]);";
    agrees(before, body, |x| {
        let (i, j) = ((x[0] + 3.0).floor() as usize % 5, x[1].abs() as usize);
        let (mut a, mut b, mut v, mut m) = ([x[0], x[1]], [x[0], x[1], x[2]], x, [[x[0], x[1]], [x[2], x[3]]]);
        b[j % 3] = x[3];
        a[(j % 3) & 1] += x[3];
        v[j] = 9.0;
        m[i & 1][j & 1] = 7.0;
        let table = [1.0, -2.0, 4.0, -8.0, 16.0];
        [table[i] + v[i & 3], b[0] + 2.0 * b[1] + 3.0 * b[2], a[0] - a[1], m[0][0] + m[1][0] * m[0][1] - m[1][1]]
    });
}

#[test]
fn a_linear_field_is_exact_and_images_wrap_by_their_mode() {
    let before = "layout(set = 0, binding = 1) uniform texture3D image;\nlayout(set = 0, binding = 2) uniform sampler s;\n\
                  layout(set = 0, binding = 3) uniform B { mat4 m; float k; };";
    let body = "result = texture(sampler3D(image, s), x.xyz) * k + vec4(0.0, 0.0, 0.0, m[3][0]) \
                + vec4(texelFetch(sampler3D(image, s), ivec3(1, 0, 2), 0).x, textureSize(sampler3D(image, s), 0).y, 0.0, 0.0);";
    let size = [5u32, 3, 4];
    let mut texels = Vec::new();
    for (k, j, i) in (0..4).flat_map(|k| (0..3).flat_map(move |j| (0..5).map(move |i| (k, j, i)))) {
        let [x, y, z] = [i as f32, j as f32, k as f32];
        texels.push([x + 2.0 * y - z, 3.0 * z, 1.0, x * y * z]);
    }
    let mut block = [0f32; 17];
    (block[12], block[16]) = (0.25, 2.0);
    let mut inputs = Inputs {
        blocks: BTreeMap::from([(3, block.iter().flat_map(|value| value.to_le_bytes()).collect())]),
        images: BTreeMap::from([(1, Texture { size, texels })]),
        ..Inputs::default()
    };
    let values: Vec<[f64; 4]> = points(400).into_iter().map(|p| p.map(|t| 4.0 * t - 1.5)).collect();
    for wrap in [Wrap::Clamp, Wrap::Repeat, Wrap::Mirror] {
        inputs.samplers.insert(2, wrap);
        for (value, found) in values.iter().zip(both(before, body, &inputs, &values)) {
            // Where the coordinates are among the texels, a trilinear function is itself.
            let place = |axis: usize| {
                let n = f64::from(size[axis]);
                let t = match wrap {
                    Wrap::Clamp => value[axis].clamp(0.0, 1.0),
                    Wrap::Repeat => value[axis] - value[axis].floor(),
                    Wrap::Mirror => {
                        let t = value[axis].rem_euclid(2.0);
                        if t > 1.0 { 2.0 - t } else { t }
                    }
                };
                let held = (t * n - 0.5).clamp(0.0, n - 1.0);
                (held, wrap != Wrap::Repeat || (t * n - 0.5 - held).abs() < 1e-12)
            };
            let [(x, a), (y, b), (z, c)] = [0, 1, 2].map(place);
            if a && b && c {
                let expected = [2.0 * (x + 2.0 * y - z) - 1.0, 6.0 * z + 3.0, 2.0, 2.0 * x * y * z + 0.25];
                for channel in 0..4 {
                    assert!(
                        (found[channel] - expected[channel]).abs() < 1e-12,
                        "{wrap:?} {value:?}: {found:?}, expected {expected:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn what_is_missing_or_not_covered_is_said_with_its_place() {
    let fails = |before: &str, body: &str| read(before, body).err().map(|error| error.to_string()).unwrap_or_default();
    let error = fails("", "float whole;\nresult = vec4(modf(x.x, whole), whole, 0.0, 0.0);");
    // Compilers write it as one of two instructions, of which naga reads one and calls it Modf.
    assert_eq!(error.to_lowercase(), "the exact evaluator does not cover the function modf (test.frag:7)");
    let error = fails("", "result = vec4(\nunpackHalf2x16(uint(x.x)), 0.0, 0.0);");
    assert_eq!(error, "the exact evaluator does not cover the function Unpack2x16float (test.frag:7)");
    let before = "layout(set = 0, binding = 4) uniform B { float k; };";
    let program = program(before, "result = x * k;");
    let error = program.bind(&Inputs::default()).unwrap_err().to_string();
    assert_eq!(error, "binding 4 needs a uniform block; add it to `Inputs`");
    let inputs = Inputs { blocks: BTreeMap::from([(4, vec![0; 2])]), ..Inputs::default() };
    let error = program.bind(&inputs).unwrap_err().to_string();
    assert_eq!(error, "binding 4 has a block of 2 bytes, but the program needs at least 4");
    let inputs = Inputs { blocks: BTreeMap::from([(4, vec![0; 4])]), ..Inputs::default() };
    let bound = program.bind(&inputs).unwrap();
    let empty = Invocations::<f64> { fragment_coordinates: vec![[0.0; 4]], varyings: BTreeMap::new() };
    let error = bound.run(&empty).unwrap_err().to_string();
    assert_eq!(error, "the program reads location 0, but the invocations have none");
}

#[test]
fn specialization_constants_get_their_values() {
    let text = "#version 450\nlayout(constant_id = 3) const int N = 4;\nlayout(location = 0) in vec4 x;\n\
                layout(location = 0) out vec4 result;\nvoid main() { result = vec4(0.0); for (int i = 0; i < N; ++i) result += x; }";
    let library = Library::new([("test.frag".to_string(), text.to_string())]);
    let spirv =
        Linker::new().unwrap().link(&library, "test.frag", Stage::Fragment, &["test.frag"], &Slots::new()).unwrap();
    for (constants, turns) in [(&[][..], 4.0), (&[(3, 7)][..], 7.0), (&[(2, 7)][..], 4.0)] {
        let program = Program::read(&spirv, constants).unwrap();
        let inputs = Inputs::default();
        let found: Vec<[f64; 4]> = evaluate(&program.bind(&inputs).unwrap(), &[[0.5; 4]]);
        assert_eq!(found, [[0.5 * turns; 4]]);
    }
}

#[test]
fn derivatives_are_differences_in_a_quad() {
    let text = "#version 450\nlayout(location = 0) out vec4 result;\n\
                void main() { vec2 p = gl_FragCoord.xy; float f = p.x * p.x + 3.0 * p.y; result = vec4(dFdx(f), dFdy(f), fwidth(f), 0.0); }";
    let library = Library::new([("test.frag".to_string(), text.to_string())]);
    let spirv =
        Linker::new().unwrap().link(&library, "test.frag", Stage::Fragment, &["test.frag"], &Slots::new()).unwrap();
    let program = Program::read(&spirv, &[]).unwrap();
    let inputs = Inputs::default();
    let bound = program.bind(&inputs).unwrap();
    let quad = [[0.5, 0.5], [1.5, 0.5], [0.5, 1.5], [1.5, 1.5]].map(|[x, y]| [x, y, 0.0, 1.0]);
    let lanes = Invocations { fragment_coordinates: quad.to_vec(), varyings: BTreeMap::new() };
    assert_eq!(bound.run(&lanes).unwrap()[&0], [[2.0, 3.0, 5.0, 0.0]; 4]);
    let lanes = Invocations { fragment_coordinates: quad[..3].to_vec(), varyings: BTreeMap::new() };
    assert!(bound.run(&lanes).unwrap_err().to_string().contains("derivatives"));
}

#[test]
fn a_loop_without_a_bound_gives_the_whole_line() {
    let body = "float t = x.x; for (; t < 10.0; t += x.y) {} result = vec4(t, x.z, 0.0, 0.0);";
    let program = program("", body);
    let inputs = Inputs::default();
    let bound = program.bind(&inputs).unwrap();
    let boxes = vec![[Interval::new(0.0), Interval { lo: 0.0, hi: 1.0 }, Interval::new(2.0), Interval::new(0.0)]];
    let lanes = Invocations { fragment_coordinates: Vec::new(), varyings: BTreeMap::from([(0, boxes)]) };
    let found = bound.run(&lanes).unwrap()[&0][0];
    assert!(found[0].lo <= 10.0 && found[0].hi >= 11.0, "{:?}", found[0]);
    assert_eq!((found[1].lo, found[1].hi), (2.0, 2.0));
}

#[test]
fn every_program_of_every_preset_lowers() {
    let library = shader::shipped();
    for name in scene::names() {
        let mut scene = scene::preset(name).unwrap();
        let own = scene.quality.pass;
        let has_rays = !scene.is_half_angle();
        for pass in [Pass::March, own].into_iter().filter(|pass| has_rays || *pass == own) {
            scene.quality.pass = pass;
            let variant = Variant::of(&scene, &library).unwrap();
            let linked = variant.program(&library, Linker::new).unwrap();
            let start = std::time::Instant::now();
            let program = Program::read(&linked.fragment, &[]).unwrap_or_else(|error| panic!("{name}: {error}"));
            let ms = start.elapsed().as_secs_f64() * 1e3;
            println!("{name}, {}: {} instructions, {ms:.1} ms", variant.entries[1], program.instructions());
            if pass == own {
                let purpose = if has_rays { Purpose::Shadow } else { Purpose::Light };
                let shadow = variant.for_purpose(purpose, &library).unwrap().program(&library, Linker::new).unwrap();
                Program::read(&shadow.fragment, &[]).unwrap_or_else(|error| panic!("shadow of {name}: {error}"));
            }
        }
    }
}

#[test]
fn a_disjunction_holds_where_its_second_operand_is_known() {
    // `x.x < 1.0` is undecided; the other operand decides the result.
    let before = "";
    for (text, expected) in [
        ("bool h = !(x.x < 1.0), near = x.y < 10.0; result = vec4((h ? near : !h) ? x.z : 9.0);", [0.25, 0.5]),
        ("bool h = !(x.x < 1.0), near = x.y < 10.0; result = vec4((h ? h : near) ? x.z : 9.0);", [0.25, 0.5]),
        ("bool h = !(x.x < 1.0), far = x.y > 10.0; result = vec4((h ? !h : far) ? 9.0 : x.z);", [0.25, 0.5]),
        ("bool h = !(x.x < 1.0), far = x.y > 10.0; result = vec4((h ? far : h) ? 9.0 : x.z);", [0.25, 0.5]),
        ("bool h = !(x.x < 1.0), near = x.y < 10.0; result = vec4((h ? near : h) ? x.z : 9.0);", [0.25, 9.0]),
    ] {
        let program = program(before, text);
        let inputs = Inputs::default();
        let bound = program.bind(&inputs).unwrap_or_else(|error| panic!("{error}"));
        let place = [[0.5, 1.5], [0.0, 1.0], [0.25, 0.5], [0.0, 0.0]].map(|[lo, hi]| Interval { lo, hi });
        let lanes = Invocations { fragment_coordinates: Vec::new(), varyings: BTreeMap::from([(0, vec![place])]) };
        let [found, ..] = bound.run(&lanes).unwrap_or_else(|error| panic!("{error}"))[&0][0];
        assert_eq!([found.lo, found.hi], expected, "{text}");
        both(before, text, &inputs, &points(60).into_iter().map(|p| p.map(|t| 3.0 * t - 1.0)).collect::<Vec<_>>());
    }
}
