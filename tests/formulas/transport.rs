//! Half-angle slicing with translucency, and volumes in bricks.

use crate::formulas::harness::{At, Check};
use crate::formulas::light::in_light_space;
use crate::formulas::medium::medium;
use crate::formulas::surface::material;
use crate::formulas::values::{c, filtered, image};
use glam::DVec3;
use hypertexture::eval::{Texture, Wrap};
use hypertexture::shader::Library;

crate::rows! {
    g13_the_light_of_a_slice_is_that_before_and_behind_it = half_angle,
        "shadow/half_angle.glsl": "0.5 * (light +" => "0.25 * (light +",
        "shadow/half_angle.glsl": "shadow_bias * normal" => "-shadow_bias * normal";
    g13_light_goes_straight_on_without_scattering = straight_on,
        "scatter/none.glsl": "left * texelFetch" => "texelFetch";
    g13_scattered_light_is_blurred_by_its_path = blurred,
        "scatter/cone.glsl": "pow(vec3(left), 1.0 - transport_color.rgb)" => "vec3(left)",
        "scatter/cone.glsl": "(variance - n * n)" => "(variance + n * n)";
    g13_translucent_matter_scatters_to_all_sides = |l| medium(l, "translucent", |at| {
        material(at) * (at.vector("ambient_color") + 0.5 * at.vector("light_color"))
    }),
        "medium/translucent.glsl": "ambient_color.rgb +" => "ambient_color.rgb -";
    m03_a_dense_volume_has_a_texel_for_each_voxel = |l| dense(l, "dense"),
        "storage/dense.glsl": "ivec3(0)" => "ivec3(1)",
        "storage/dense.glsl": "volume, tex_coord)" => "volume, 1.0 - tex_coord)";
    a_device_weighs_eight_texels = |l| lookups(l, "device"),
        "filter/device.glsl": "textureLod(image, p, level)" => "textureLod(image, p, 0.0)",
        "filter/device.glsl": "textureLod(image, p, 0.0)" => "textureLod(image, 1.0 - p, 0.0)";
    a_shader_weighs_eight_texels = |l| lookups(l, "exact"),
        "filter/exact.glsl": "(size) - 1.0)), 0)" => "(size) - 2.0)), 0)",
        "filter/exact.glsl": "mix(c, d, w.x), w.y)" => "mix(c, d, w.y), w.y)",
        "filter/exact.glsl": "vec3(1.0, 1.0, 0.0))" => "vec3(1.0, 0.0, 0.0))",
        "filter/exact.glsl": "floor(level) + 1.0)" => "floor(level))";
    a_device_filters_tables = |l| tables(l, "device"),
        "filter/device.glsl": "lookup_line(image, p) textureLod(image, p, 0.0)" => "lookup_line(image, p) textureLod(image, 1.0 - (p), 0.0)",
        "filter/device.glsl": "lookup_plane(image, p) textureLod(image, p, 0.0)" => "lookup_plane(image, p) textureLod(image, (p).yx, 0.0)";
    a_shader_filters_tables = |l| tables(l, "exact"),
        "filter/exact.glsl": "line_texel(image, p, 1), line_place" => "line_texel(image, p, 0), line_place",
        "filter/exact.glsl": "+ step, 0, textureSize(image, 0) - 1)" => "+ step, 0, textureSize(image, 0) - 2)",
        "filter/exact.glsl": "plane_texel(image, p, ivec2(1, 0))" => "plane_texel(image, p, ivec2(0, 0))",
        "filter/exact.glsl": "ivec2(0), textureSize(image, 0) - 1)" => "ivec2(0), textureSize(image, 0) - 2)";
    m57_a_footprint_is_filtered_around_its_place = |l| dense(l, "anisotropic"),
        "storage/anisotropic.glsl": "ivec3(0)" => "ivec3(1)",
        "storage/anisotropic.glsl": "clamp(tex_coord" => "clamp(1.0 - tex_coord";
    g14_bricks_are_filtered_as_the_whole_volume = bricks,
        "storage/sparse.glsl": "at - BRICK * vec3(brick)" => "at",
        "storage/sparse.glsl": "ivec3(entry.xyz) - int(BRICK) * brick" => "ivec3(entry.xyz)";
    m01_slices_face_the_eye = |l| planes(l, "facing", |at| -at.p[0][2]),
        "planes/facing.glsl": "-position.z" => "position.z";
    g13_slices_face_half_way_to_the_light = |l| planes(l, "half_angle", |at| -at.vector("slice_axis").dot(at.place(0))),
        "planes/half_angle.glsl": "-dot" => "dot";
}

/// Direct light in A and scattered light in RGB, from the buffers of the light: on a hard surface that before the slice.
fn half_angle(library: &Library) -> f64 {
    let text = "#include <shadow>\nvoid check() { out0.xyz = shadow(0.5, p1.xyz); out1.xyz = shadow(0.5, vec3(0.0)); }";
    let check = Check::new(library, &[("shadow", "half_angle")], text).given(|random, _| {
        [[0.5; 4], random.direction().extend(0.0).to_array(), [0.0; 4], random.eye().extend(0.0).to_array()]
    });
    check.holds(1e-6, |at| {
        let light = |image: &str, position: DVec3| {
            let place = in_light_space(at, position);
            let [r, g, b, direct] = filtered(at.texture(image), &[place.x, place.y], Wrap::Clamp);
            DVec3::splat(direct).lerp(DVec3::new(r, g, b), at.number("translucency"))
        };
        let eye = at.place(3);
        let hard = light("light_before_image", eye + at.number("shadow_bias") * at.place(1));
        let soft = (light("light_before_image", eye) + light("light_behind_image", eye)) / 2.0;
        [hard.to_array().as_slice(), &[0.0], &soft.to_array()].concat()
    })
}

const PASSED: &str = "#include <scatter>\nvoid check() { out0 = passed(p0.xy, p0.z, p0.w); }";

/// The texel of the light's buffer at a point: points go row by row over 64 pixels.
fn before(at: &At<'_>, counter: &std::cell::Cell<usize>) -> [f64; 4] {
    let pixel = counter.get() % 320;
    counter.set(counter.get() + 1);
    at.texture("light_before_image").texels[pixel].map(f64::from)
}

fn straight_on(library: &Library) -> f64 {
    let counter = std::cell::Cell::new(0);
    Check::new(library, &[], PASSED).holds(1e-9, |at| before(at, &counter).map(|light| at.p[0][2] * light).to_vec())
}

/// Four taps beside a ray, whose variance is that of the path: scatter^2 times it. Between two texels a filter of weight w
/// has the variance of both: n^2 (1 - w) + (n + 1)^2 w.
fn blurred(library: &Library) -> f64 {
    let counter = std::cell::Cell::new(0);
    let check = Check::new(library, &[("scatter", "cone")], PASSED).with("shadow_side", &[64.0]).given(|random, _| {
        let left = if random.unit() < 0.2 { 1.0 } else { random.unit() };
        let first = [random.within(0.2, 0.8), random.within(0.2, 0.8), left, random.within(0.01, 0.3)];
        [first, [0.0; 4], [0.0; 4], random.eye().extend(0.0).to_array()]
    });
    check.holds(1e-6, |at| {
        let ([x, y, left, path], side) = (at.p[0], at.number("shadow_side"));
        let away = at.matrix("shadow_matrix").transform_point3(at.place(3)).length();
        let texel = 2.0 * at.number("shadow_rim") * away / side;
        let variance = at.number("scatter").powi(2) * path / texel.powi(2);
        let whole = variance.sqrt().floor();
        let tap = whole + (variance - whole.powi(2)) / ((whole + 1.0).powi(2) - whole.powi(2));
        let light = |dx: f64, dy: f64| {
            let at_tap = [x + dx * tap / side, y + dy * tap / side];
            DVec3::from_slice(&filtered(at.texture("light_before_image"), &at_tap, Wrap::Clamp))
        };
        let mean = (light(1.0, 1.0) + light(1.0, -1.0) + light(-1.0, 1.0) + light(-1.0, -1.0)) / 4.0;
        let spared = (DVec3::ONE - at.vector("transport_color")).to_array().map(|part| left.powf(part));
        (mean * DVec3::from(spared)).extend(left * before(at, &counter)[3]).to_array().to_vec()
    })
}

const STORAGE: &str = "#include <storage>
    void check() { out0 = volume_at(p0.xyz); out1.xyz = vec3(texel_shift(ivec3(floor(p1.xyz)))); }";

fn dense(library: &Library, module: &str) -> f64 {
    let check = Check::new(library, &[("storage", module)], STORAGE)
        .given(|random, _| [random.in_cube(1.2).extend(0.0).to_array(); 4]);
    check.holds(1e-9, |at| {
        let texel = filtered(at.texture("volume_image"), &at.p[0][..3], Wrap::Clamp);
        [texel.as_slice(), &[0.0; 3]].concat()
    })
}

/// Of a volume with sides of any length, which clamps, and of a block of two levels, which repeats, at and between them.
fn lookups(library: &Library, module: &str) -> f64 {
    let text = "#include <filter>
        void check() {
            out0 = lookup_volume(volume, p0.xyz);
            out1 = lookup_block(noise_block, p1.xyz, p1.w);
        }";
    let random = |p: DVec3| [0.0, 1.0, 2.0, 3.0].map(|c| (17.3 * p.x + 11.9 * p.y + 7.7 * p.z + 0.3 * c).fract());
    let levels = [8, 4].map(|side| image([side; 3], random));
    let both = Texture { size: [8; 3], texels: levels.iter().flat_map(|level| level.texels.clone()).collect() };
    let check = Check::new(library, &[("filter", module)], text)
        .with_texture("volume_image", image([5, 7, 6], random))
        .with_texture("noise_image", both)
        .given(|random, _| {
            let level = if random.unit() < 0.3 { 0.0 } else { random.unit() };
            [
                random.in_cube(1.2).extend(0.0).to_array(),
                random.in_cube(3.0).extend(level).to_array(),
                [0.0; 4],
                [0.0; 4],
            ]
        });
    check.holds(1e-9, move |at| {
        let [low, high] = [0, 1].map(|index| filtered(&levels[index], &at.p[1][..3], Wrap::Repeat));
        let between = |channel: usize| low[channel] + at.p[1][3] * (high[channel] - low[channel]);
        let block = [0, 1, 2, 3].map(between);
        [filtered(at.texture("volume_image"), &at.p[0][..3], Wrap::Clamp), block].concat()
    })
}

/// Of a table of one dimension and of two, which clamp.
fn tables(library: &Library, module: &str) -> f64 {
    let text = "#include <filter>
        void check() { out0 = lookup_line(transfer_map, p0.x); out1 = lookup_plane(segment_map, p1.xy); }";
    let random = |p: DVec3| [0.0, 1.0, 2.0, 3.0].map(|c| (17.3 * p.x + 11.9 * p.y + 0.3 * c).fract());
    let check = Check::new(library, &[("filter", module)], text)
        .with_texture("transfer_image", image([9, 1, 1], random))
        .with_texture("segment_image", image([5, 7, 1], random))
        .given(|random, _| [random.in_cube(1.2).extend(0.0).to_array(); 4]);
    check.holds(1e-9, |at| {
        let line = filtered(at.texture("transfer_image"), &at.p[0][..1], Wrap::Clamp);
        [line, filtered(at.texture("segment_image"), &at.p[1][..2], Wrap::Clamp)].concat()
    })
}

/// 17 texels along a side in eight bricks of eight cells: four are stored, each with the texels that it shares with its
/// neighbors, one after another along x; four are one texel each.
fn bricks(library: &Library) -> f64 {
    const CELLS: u32 = 8;
    let stored = |brick: u32| brick.count_ones().is_multiple_of(2);
    let number = move |brick: u32| f64::from((0..brick).filter(|other| stored(*other)).count() as u32);
    let index = image([2; 3], move |p| {
        let side = (p * 2.0).floor();
        let brick = side.x as u32 + 2 * side.y as u32 + 4 * side.z as u32;
        if stored(brick) { [9.0 * number(brick), 0.0, 0.0, 2.0] } else { [0.1 * f64::from(brick), 0.5, 0.25, 0.75] }
    });
    let pool =
        image([36, 9, 9], |p| [(7.3 * p.x + 3.1 * p.y).fract(), (5.7 * p.y + 2.3 * p.z).fract(), p.z, 0.5 * p.x]);
    let side = f64::from(2 * CELLS + 1);
    let check = Check::new(library, &[("storage", "sparse")], STORAGE)
        .with("volume_texel", &[1.0 / side; 3])
        .with_texture("brick_image", index)
        .with_texture("volume_image", pool)
        .given(move |random, _| {
            let p = DVec3::splat(0.5) + random.in_cube(0.52);
            let voxel = (DVec3::splat(0.5) + random.in_cube(0.5)) * (side - 1.0);
            [p.extend(0.0).to_array(), voxel.extend(0.0).to_array(), [0.0; 4], [0.0, 0.0, -1.0, 0.0]]
        });
    check.holds(1e-5, move |at| {
        let brick_of = |voxel: DVec3| (voxel / f64::from(CELLS)).floor().clamp(DVec3::ZERO, DVec3::ONE);
        let number_of = |b: DVec3| b.x as u32 + 2 * b.y as u32 + 4 * b.z as u32;
        let voxel = (at.place(0) / c(1.0 / side) - 0.5).max(DVec3::ZERO);
        let brick = brick_of(voxel);
        let within = (voxel - brick * f64::from(CELLS)).min(DVec3::splat(f64::from(CELLS)));
        let texel = match stored(number_of(brick)) {
            true => {
                let place = (within + 0.5 + DVec3::X * 9.0 * number(number_of(brick))) / DVec3::new(36.0, 9.0, 9.0);
                filtered(at.texture("volume_image"), &place.to_array(), Wrap::Clamp)
            }
            false => [c(0.1 * f64::from(number_of(brick))), 0.5, 0.25, 0.75],
        };
        let voxel = at.place(1).floor();
        let brick = brick_of(voxel);
        let shift = match stored(number_of(brick)) {
            true => DVec3::X * 9.0 * number(number_of(brick)) - brick * f64::from(CELLS),
            false => -voxel,
        };
        [texel.as_slice(), &shift.to_array()].concat()
    })
}

fn planes(library: &Library, module: &str, formula: fn(&At<'_>) -> f64) -> f64 {
    let text = "#include <planes>\nvoid check() { out0.x = plane_depth(p0.xyz); }";
    Check::new(library, &[("planes", module)], text).holds(1e-9, |at| vec![formula(at)])
}
