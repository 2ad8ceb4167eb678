//! Shells around open and closed surfaces.

use super::*;
use crate::{FieldError, transform_with_closest};
use hypertexture_shape::{Content, Solid, Volume};

const REQUEST: Request = Request { resolution: 40, margin: 0.2, band: 0.25, iso: 0.0, shell: 0.3 };

/// Asserts that the field is the distance to a surface minus half of the shell, and that closest points lie on the shell.
fn assert_shell(shape: &Shape, off: f64, distance: impl Fn(DVec3) -> f64) {
    let (field, closest, report) = transform_with_closest(shape, &REQUEST, &|_| ()).unwrap();
    let (grid, half, voxel) = (field.grid, f64::from(0.5 * REQUEST.shell), f64::from(field.grid.spacing.x));
    assert_eq!((report.closing_triangles, report.buried), (0, false));
    let bounds = shape.bounds();
    let reach = REQUEST.margin + 0.5 * REQUEST.shell - 1e-4;
    assert!(grid.origin.cmple(bounds.min - reach).all());
    let [nx, ny, nz] = grid.size;
    let (mut inside, mut wrong) = (0, 0);
    for index in 0..nx * ny * nz {
        let at = grid.position(index % nx, index / nx % ny, index / (nx * ny)).as_dvec3();
        let (found, exact) = (f64::from(field.values[index as usize]), distance(at) - half);
        inside += u32::from(found < 0.0);
        if exact.abs() <= f64::from(REQUEST.band) {
            assert!((found - exact).abs() < off + 2e-4 * voxel, "{at}: {found} {exact}");
        } else {
            assert!(
                found <= exact + off + 2e-4 * voxel && found >= exact - 0.25 * voxel - off,
                "{at}: {found} {exact}"
            );
        }
        // On the surface itself the closest point may be on either side of the shell.
        let point = closest.points[index as usize].as_dvec3();
        let is_off = (distance(point) - half).abs() > 0.26 * voxel + off;
        wrong += u32::from(is_off && distance(at) > off + 1e-3);
    }
    assert!(inside > 100, "{inside}");
    assert_eq!(wrong, 0);
}

#[test]
fn an_open_square_becomes_a_plate() {
    let positions = [[-1.0, -0.5], [1.0, -0.5], [1.0, 0.5], [-1.0, 0.5]].map(|[x, y]| Vec3::new(x, y, 0.1)).to_vec();
    // Inconsistently wound, which does not matter to a shell.
    let mesh = Mesh { positions, triangles: vec![[0, 1, 2], [0, 3, 2]], ..Mesh::default() };
    assert_shell(&Shape::Mesh(mesh), 0.0, |p| {
        let beyond = (p.abs() - DVec3::new(1.0, 0.5, 0.0)).with_z(p.z - 0.1);
        DVec3::new(beyond.x.max(0.0), beyond.y.max(0.0), beyond.z).length()
    });
}

#[test]
fn what_is_closed_becomes_hollow() {
    let far = |p: DVec3| (p.length() - 0.8).abs();
    assert_shell(&Shape::Solid(Solid::Sphere { radius: 0.8 }), 0.0, far);
    let size = [41; 3];
    let place = |i: u32| (Vec3::new((i % 41) as f32, (i / 41 % 41) as f32, (i / 1681) as f32) - 20.0) * 0.05;
    let values = (0..size.iter().product()).map(|i| 0.8 - place(i).length()).collect();
    let (origin, steps) = (Vec3::splat(-1.0), Mat3::from_diagonal(Vec3::splat(0.05)));
    let volume = Volume { size, origin, steps, values, content: Content::Scalar };
    // The interpolated ball is flat between samples.
    assert_shell(&Shape::Volume(volume), 2e-3, far);
}

#[test]
fn a_shell_has_a_thickness() {
    for shell in [-0.1, f32::NAN, f32::INFINITY] {
        let error = transform(&Shape::Solid(Solid::Sphere { radius: 1.0 }), &Request { shell, ..REQUEST }, &|_| ());
        assert!(matches!(error, Err(FieldError::Length { name: "shell", .. })), "{shell}");
    }
}
