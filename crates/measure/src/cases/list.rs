//! The list of cases.

use super::analytic_scenes::{COLOR_BY_DEPTH, HOMOGENEOUS, PERLIN_BALLS, SLANTED, SOFT_BALLS, TWO_TONES};
use super::run::Measure::{Analytic, Rows};
use super::run::{Case, Measure, Suite};
use super::{
    camera, data, drivers, fields, invariances, lenses, matter, noise, opacity, optimizer, relations, shaping, volumes,
};

const fn verify(number: u32, name: &'static str, measure: Measure) -> Case {
    Case { suite: Suite::Verify, number, name, measure }
}

const fn stress(number: u32, name: &'static str, measure: Measure) -> Case {
    Case { suite: Suite::Stress, number, name, measure }
}

/// The cases of both suites, in the order of their numbers.
pub const CASES: &[Case] = &[
    verify(1, "homogeneous matter", Analytic(HOMOGENEOUS)),
    verify(2, "color by depth", Analytic(COLOR_BY_DEPTH)),
    verify(3, "soft ball", Analytic(SOFT_BALLS)),
    verify(4, "soft ball, opacity of PH", Analytic(PERLIN_BALLS)),
    verify(5, "two-tone ball", Analytic(TWO_TONES)),
    verify(6, "fields of voxels", Rows(volumes::fields)),
    verify(7, "lenses", Rows(lenses::convergence)),
    verify(8, "noise", Rows(volumes::noise)),
    verify(9, "invariances", Rows(invariances::rows)),
    verify(10, "wide view", Analytic(SLANTED)),
    verify(11, "thin layers", Rows(matter::formats)),
    verify(12, "drivers", Rows(drivers::rows)),
    stress(1, "bias near 1", Rows(shaping::bias_near_1)),
    stress(2, "bias near 0", Rows(shaping::bias_near_0)),
    stress(3, "gain near its ends", Rows(shaping::gain_at_ends)),
    stress(4, "shaping with unbounded slope", Rows(relations::steep)),
    stress(5, "shaping beyond [0, 1]", Rows(shaping::beyond)),
    stress(6, "softness to 0", Rows(matter::soft_to_hard)),
    stress(7, "soft region wider than the object", Rows(matter::wide)),
    stress(8, "warnings", Rows(relations::warned)),
    stress(9, "full density over a path of 0", Rows(opacity::ends)),
    stress(10, "opacity of a point", Rows(opacity::points)),
    stress(11, "opacity rate", Rows(matter::rates)),
    stress(12, "opacity of a segment", Rows(opacity::segments)),
    stress(13, "unions", Rows(data::unions)),
    stress(14, "many slices", Rows(matter::slices)),
    stress(15, "early termination", Rows(matter::termination)),
    stress(16, "wide views", Rows(camera::wide)),
    stress(17, "codes of colors", Rows(data::codes)),
    stress(18, "eye at and in the matter", Rows(camera::eye)),
    stress(19, "formats of the target", Rows(matter::formats)),
    stress(20, "bits of a distance", Rows(fields::bits)),
    stress(21, "weights of filters", Rows(fields::filters)),
    stress(22, "normals on the medial axis", Rows(fields::medial)),
    stress(23, "normals along an axis", Rows(fields::normals)),
    stress(24, "noise far from the origin", Rows(noise::far)),
    stress(25, "noise around 0", Rows(noise::negative)),
    stress(26, "noise beyond integers", Rows(noise::endless)),
    stress(27, "undefined GLSL", Rows(data::texts)),
    stress(28, "noise that repeats", Rows(noise::periods)),
    stress(29, "octaves past Nyquist", Rows(relations::nyquist)),
    stress(30, "bounds of noise", Rows(noise::bounds)),
    stress(31, "unbounded matter", Rows(data::hulls)),
    stress(32, "lenses by ever more steps", Rows(lenses::steps)),
    stress(33, "index of refraction to 1", Rows(lenses::to_none)),
    stress(34, "voxels that are not finite", Rows(data::voxels)),
    stress(35, "thin and odd grids", Rows(fields::thin)),
    stress(36, "programs with and without optimizer", Rows(optimizer::rows)),
    stress(37, "size of the object", Rows(fields::sizes)),
    stress(38, "meshes that are not closed", Rows(data::meshes)),
    stress(39, "turns of the trackball", Rows(camera::turns)),
    stress(40, "skipping of empty space", Rows(relations::skipping)),
    stress(41, "long times", Rows(relations::times)),
];

/// The cases of a suite.
pub fn suite(suite: Suite) -> impl Iterator<Item = Case> {
    CASES.iter().copied().filter(move |case| case.suite == suite)
}
