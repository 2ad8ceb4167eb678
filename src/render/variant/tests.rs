//! Programs of scenes and their inputs.

use super::{NoiseImage, PassImage, Program, Purpose, Use, Variant};
use crate::scene::{EFFECTS, Scene, preset};
use crate::shader::{self, Linker};

#[test]
fn soft_matter_is_found_and_shaded_at_once_on_a_gpu() {
    let for_device = |name: &str, on_processor| {
        let variant = Variant::of(&preset(name).unwrap(), &shader::shipped()).unwrap();
        variant.for_device(on_processor).module("empty_space").unwrap().to_string()
    };
    for name in ["fire", "tank", "fur"] {
        assert_eq!([true, false].map(|on_processor| for_device(name, on_processor)), ["skip", "leap"], "{name}");
    }
    assert_eq!([true, false].map(|on_processor| for_device("lit", on_processor)), ["skip"; 2]);
}

fn program(scene: &Scene) -> Program {
    let library = shader::shipped();
    Variant::of(scene, &library).unwrap().program(&library, Linker::new).unwrap()
}

#[test]
fn m19_the_six_effects_ship_as_linked_programs() {
    for effect in EFFECTS {
        for object in ["teapot", "sphere", "cube", "torus"] {
            let mut scene = preset(effect).unwrap();
            scene.object.input = object.into();
            assert!(program(&scene).shipped, "{effect} on {object}");
            if scene.light.shadows {
                let library = shader::shipped();
                let shadow = Variant::of(&scene, &library).unwrap().for_purpose(Purpose::Shadow, &library).unwrap();
                assert!(shadow.program(&library, Linker::new).unwrap().shipped, "shadows of {effect} on {object}");
            }
        }
    }
}

#[test]
fn a_shipped_program_is_the_one_that_run_time_links() {
    let library = shader::shipped();
    for effect in EFFECTS {
        let variant = Variant::of(&preset(effect).unwrap(), &library).unwrap();
        let shipped = variant.program(&library, || unreachable!("it ships")).unwrap();
        let other = library.clone().with_module("dmf", "unused", "");
        let linked = variant.program(&other, Linker::new).unwrap();
        assert!(!linked.shipped);
        assert_eq!((shipped.vertex, shipped.fragment), (linked.vertex, linked.fragment), "{effect}");
    }
}

#[test]
fn programs_are_cached_on_disk_by_their_modules() {
    let library = shader::shipped().with_module(
        "dmf",
        "own",
        "// Own.\nfloat own(float density, Sample s) { return density; }\n",
    );
    let mut scene = preset("fur").unwrap();
    scene.parameters.clear();
    (scene.effect.dmf, scene.effect.medium) = (vec!["own".into()], "lit".into());
    let variant = Variant::of(&scene, &library).unwrap();
    let first = variant.program(&library, Linker::new).unwrap();
    if hypertexture_support::disk_cache::default_folder().is_some() {
        assert!(variant.program(&library, || unreachable!("it is on the disk")).unwrap() == first);
    }
    let other =
        library.with_module("dmf", "own", "// Own.\nfloat own(float density, Sample s) { return 0.5 * density; }\n");
    assert!(variant.program(&other, Linker::new).unwrap().fragment != first.fragment);
}

#[test]
fn what_a_scene_does_not_need_is_not_bound() {
    let mut scene = preset("lit").unwrap();
    let blocks = ["noise block", "turbulence block", "transfer map", "segment table", "classified volume", "index map"];
    assert_eq!(program(&scene).left_out(), [&blocks[..], &["closest points", "shadow volume"]].concat());
    assert!(!program(&preset("fur").unwrap()).left_out().contains(&"closest points"));
    assert!(!program(&preset("fur").unwrap()).left_out().contains(&"shadow volume"));
    scene.object.input = "sphere".into();
    assert!(program(&scene).left_out().contains(&"volume"));
    assert!(!program(&preset("fur").unwrap()).left_out().contains(&"noise block"));
    assert!(program(&preset("fur").unwrap()).left_out().contains(&"transfer map"));
    assert!(!program(&preset("fire").unwrap()).left_out().contains(&"transfer map"));
}

#[test]
fn normals_are_left_out_where_no_module_reads_them() {
    let mut scene = preset("solid").unwrap();
    scene.effect.surface = "solid_unlit".into();
    assert_eq!(Variant::of(&scene, &shader::shipped()).unwrap().module("object"), Some("distance"));
    assert_eq!(Variant::of(&preset("solid").unwrap(), &shader::shipped()).unwrap().module("object"), Some("normals"));
}

#[test]
fn p54_shadow_programs_read_only_images_of_the_picture() {
    let library = shader::shipped();
    for (effect, object) in EFFECTS.into_iter().chain(["shells"]).flat_map(|e| [(e, "teapot"), (e, "torus")]) {
        let mut scene = preset(effect).unwrap();
        (scene.object.input, scene.light.shadows) = (object.into(), true);
        let variant = Variant::of(&scene, &library).unwrap();
        let picture = variant.program(&library, Linker::new).unwrap();
        let shadow = variant.for_purpose(Purpose::Shadow, &library).unwrap().program(&library, Linker::new).unwrap();
        let images = shadow.resources.iter().filter(|resource| !matches!(resource.holds, Use::Block(_)));
        for image in images {
            assert!(picture.reads(&image.name), "{effect} on {object}: {}", image.name);
        }
        assert!(!shadow.reads_image(PassImage::Shadow) && shadow.reads("View"));
    }
}

#[test]
fn m28_the_constants_are_those_of_the_paper() {
    let program = program(&preset("lit").unwrap());
    let Some(Use::Block(block)) = program.resources.iter().find(|r| r.name == "Constants").map(|r| r.holds.clone())
    else {
        panic!("no block of constants")
    };
    let names: Vec<_> = block.members.iter().map(|member| member.name.as_str()).collect();
    let expected = [
        "normal_matrix",
        "material_color",
        "ambient_color",
        "light_color",
        "light_position",
        "specular_power",
        "specular_strength",
        "iso_value",
        "outer_iso_value",
    ];
    assert_eq!(names[..expected.len()], expected, "what follows says how to read the volume");
}

#[test]
fn phases_are_those_of_another_variant() {
    let own = Variant::of(&preset("lit").unwrap(), &shader::shipped()).unwrap();
    let direct = own.without_two_phase();
    assert!(own.uses_two_phase() && !direct.uses_two_phase());
    assert_eq!(direct.clone().with_phases_of(&own).key(), own.key());
    assert_eq!(own.with_phases_of(&direct).key(), direct.key());
}

#[test]
fn m12_any_two_dmfs_make_a_stack() {
    let mut scene = preset("fur").unwrap();
    scene.effect.dmf = vec!["fur".into(), "fire".into()];
    let program = program(&scene);
    assert!(program.reads_image(NoiseImage::Noise) && program.reads_image(NoiseImage::TurbulenceValues));
}
