//! Fields in a space with other axes.

use glam::{Mat3, Vec3};
use hypertexture::field::{DistanceField, Grid};
use hypertexture::scene::Axis;

#[test]
fn turned_fields_are_rotated_with_the_axis_up() {
    let grid = Grid { size: [3, 4, 5], origin: Vec3::new(-1.0, 0.5, 2.0), spacing: Vec3::new(0.5, 1.0, 0.25) };
    let values = (0..60).map(|index| (index * index % 37) as f32).collect();
    let field = DistanceField { grid, values };
    let directions = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z];
    let axes = [Axis::X, Axis::Y, Axis::Z, Axis::MinusX, Axis::MinusY, Axis::MinusZ];
    for (axis, up) in axes.into_iter().zip(directions) {
        let turn = axis.turn();
        let rows = turn.map(|(from, reversed)| Vec3::AXES[from] * if reversed { -1.0 } else { 1.0 });
        let rotation = Mat3::from_cols_array_2d(&rows.map(|row| row.to_array())).transpose();
        assert_eq!(rotation.determinant(), 1.0, "{axis:?} mirrors nothing");
        assert_eq!(rotation * up, Vec3::Y, "{axis:?} points up");
        let turned = field.clone().turned(turn);
        for (i, j, k) in [(0, 0, 0), (2, 3, 4), (1, 2, 3), (2, 0, 1)] {
            let p = rotation * field.grid.position(i, j, k);
            assert!((turned.sample(p) - field.value(i, j, k)).abs() < 1e-4, "{axis:?} at {i} {j} {k}");
        }
    }
}
