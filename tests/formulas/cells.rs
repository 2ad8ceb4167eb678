//! How rays go through cells of which some are proven to be empty.

use crate::formulas::harness::Check;
use crate::formulas::knots::pcg3d;
use glam::DVec3;
use hypertexture::eval::Texture;
use hypertexture::shader::Library;

crate::rows! {
    g09_rays_pass_all_cells_that_are_empty = passes,
        "cells/grid.glsl": "1.0) - 0.5)" => "1.0) + 0.5)",
        "cells/grid.glsl": "sign(rate)" => "-sign(rate)",
        "cells/grid.glsl": "at - cell - 0.5 + reach" => "at - cell - 0.5 - reach",
        "cells/grid.glsl": "floor(at)" => "round(at)";
    g09_samples_look_back_over_partly_empty_steps = lands,
        "cells/grid.glsl": "k + leaves + SLIVER" => "k + 2.0 * leaves",
        "cells/grid.glsl": "empty_until = k + leaves" => "empty_until = leaves - k";
    p38_no_cell_is_empty_without_a_grid = |l| Check::new(l, &[], CELLS).holds(1e-12, |_| vec![0.0]),
        "cells/none.glsl": "return 0.0" => "return 1.0";
}

const CELLS: &str = "#include <cells>\nvoid check() { out0.x = empty_steps(p0.xyz, p1.xyz, 0.0); }";

/// Cells of which few may hold matter; how far it is to those, by trying all of them.
fn cells() -> Texture {
    let size = [7, 6, 5];
    let all =
        || (0..size.iter().product::<u32>()).map(|at| [at % size[0], at / size[0] % size[1], at / (size[0] * size[1])]);
    let full: Vec<[u32; 3]> = all().filter(|&cell| pcg3d(cell)[0].is_multiple_of(12)).collect();
    let away = |a: [u32; 3], b: [u32; 3]| (0..3).map(|axis| a[axis].abs_diff(b[axis])).max().unwrap();
    let nearest = |cell: [u32; 3]| full.iter().map(|other| away(cell, *other)).min().unwrap();
    Texture { size, texels: all().map(|cell| [nearest(cell) as f32 / 255.0, 0.0, 0.0, 1.0]).collect() }
}

/// No sample that is passed may hold matter, and the one that is gone to is beyond what the texel says.
fn passes(library: &Library) -> f64 {
    passes_looking(library, 0.0).max(passes_looking(library, 0.1))
}

/// The same by samples that look so far back.
fn passes_looking(library: &Library, reach: f64) -> f64 {
    let check = Check::new(library, &[("cells", "grid")], CELLS).with_texture("cell_image", cells());
    let check = check.given(|random, setting| {
        let (low, high) = (setting.vector("box_min"), setting.vector("box_max"));
        let x = low + (high - low) * (0.5 + 0.499 * random.in_cube(1.0));
        let stride = random.in_cube(0.06);
        let along_an_axis = random.unit() < 0.2;
        let stride = if along_an_axis { DVec3::new(0.0, stride.y, 0.0) } else { stride };
        [x.extend(0.0).to_array(), stride.extend(0.0).to_array(), [0.0; 4], [0.0; 4]]
    });
    let check = check.with("sample_reach", &[reach]);
    check.worst(|at, found| {
        let (grid, low, high) = (at.texture("cell_image"), at.vector("box_min"), at.vector("box_max"));
        let place = |steps: f64| {
            (at.place(0) + steps * at.place(1) - low) / (high - low) * DVec3::from(grid.size.map(f64::from))
        };
        let cell = |p: DVec3| [0, 1, 2].map(|axis| (p[axis].floor() as i64).clamp(0, i64::from(grid.size[axis]) - 1));
        let own = cell(place(0.0));
        let [x, y, z] = own.map(|index| index as u32);
        let cells = (255.0 * grid.texels[((z * grid.size[1] + y) * grid.size[0] + x) as usize][0]).round() as f64;
        // How far beyond the cells that are known to be empty, in cells.
        let beyond = |steps: f64| {
            let from_middle = place(steps) - DVec3::from(own.map(|index| index as f64 + 0.5));
            from_middle.abs().max_element() - (cells - 0.5)
        };
        let right = match (cells, found[0]) {
            (0.0, steps) => steps == 0.0,
            // One that looks back into other cells is taken.
            (_, steps) if reach > 0.0 && beyond(-1.0).abs() < 1e-9 => steps >= 0.0,
            (_, steps) if reach > 0.0 && beyond(-1.0) > 0.0 => steps == 0.0,
            (_, steps) => steps >= 1.0 && steps.fract() == 0.0 && beyond(steps - 1.0) < 1e-9 && beyond(steps) > -1e-9,
        };
        if right { 0.0 } else { f64::INFINITY }
    })
}

const LANDINGS: &str = "#include <cells>\nvoid check() {
        float first = empty_steps(p0.xyz, p1.xyz, 3.0), there = 3.0 + first;
        out0 = vec4(first, first > 0.0 ? empty_steps(p0.xyz + first * p1.xyz, p1.xyz, there) : -1.0, 0.0, 0.0);
    }";

/// A sample where a ray lands is passed where its step is in what is known to be empty, and taken where some of it is not.
fn lands(library: &Library) -> f64 {
    let check = Check::new(library, &[("cells", "grid")], LANDINGS).with_texture("cell_image", cells());
    let check = check.given(|random, setting| {
        let (low, high) = (setting.vector("box_min"), setting.vector("box_max"));
        let x = low + (high - low) * (0.5 + 0.499 * random.in_cube(1.0));
        // From a step before, which is in the same cells for most.
        [x.extend(0.0).to_array(), random.in_cube(0.4).extend(0.0).to_array(), [0.0; 4], [0.0; 4]]
    });
    check.with("sample_reach", &[0.1]).worst(|at, found| {
        let (grid, low, high) = (at.texture("cell_image"), at.vector("box_min"), at.vector("box_max"));
        let (first, second) = (found[0], found[1]);
        let size = DVec3::from(grid.size.map(f64::from));
        let place = |steps: f64| (at.place(0) + steps * at.place(1) - low) / (high - low) * size;
        let is_within = |p: DVec3| p.cmpgt(DVec3::ZERO).all() && p.cmplt(size).all();
        if first <= 0.0 || !is_within(place(first)) {
            return 0.0;
        }
        let cells = |p: DVec3| {
            let [x, y, z] = p.floor().to_array().map(|index| index as usize);
            let [columns, rows, _] = grid.size.map(|side| side as usize);
            (255.0 * grid.texels[(z * rows + y) * columns + x][0]).round() as f64
        };
        let is_known = |from: DVec3, p: DVec3| (p - from.floor() - 0.5).abs().max_element() <= cells(from) - 0.5;
        let unknown = (0..1000).map(|part| place(first - 1.0 + f64::from(part) / 1000.0));
        let unknown = unknown.filter(|&p| !is_known(place(0.0), p) && !is_known(place(first), p)).count();
        // Of a step between two cells a thousandth may be rounding.
        let right = match unknown {
            0 => second >= 1.0 || cells(place(first)) == 0.0,
            1..4 => true,
            _ => second == 0.0,
        };
        if right { 0.0 } else { f64::INFINITY }
    })
}
