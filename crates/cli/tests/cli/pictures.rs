//! Output of each command.

use super::desk::{Desk, SMALL, refused, text};
use hypertexture::scene::{ParameterValue, Reach};
use std::fs;
use std::path::Path;
use std::process::Stdio;

/// A box of 2 x 1 x 0.5.
const BOX: &str =
    "v -1 -.5 -.25\nv 1 -.5 -.25\nv 1 .5 -.25\nv -1 .5 -.25\nv -1 -.5 .25\nv 1 -.5 .25\nv 1 .5 .25\nv -1 .5 .25
f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 1 5 8 4\nf 2 3 7 6\n";

fn size_of(path: &Path) -> (u32, u32) {
    image::image_dimensions(path).unwrap()
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_render_writes_the_picture_and_says_what_it_took() {
    let desk = Desk::new();
    let said = desk.good(&format!("render torus --effect fur -o x.png {SMALL}"));
    for start in ["device ", "program ", "left out ", "rays ", "time ", "memory ", "wrote "] {
        assert!(said.lines().any(|line| line.starts_with(start)), "no line `{start}`: {said}");
    }
    assert!(said.contains("dmf=fur") && said.contains("x.png"), "{said}");
    assert_eq!(size_of(&desk.file("x.png")), (64, 64));
    let bytes = fs::read(desk.file("x.png")).unwrap();
    assert!(bytes.windows(4).any(|window| window == b"sRGB"), "no sRGB chunk");
    assert_eq!(desk.files().len(), 1, "a render writes its picture and nothing else");
    assert!(desk.good(&format!("render torus --pass slices {SMALL}")).contains("\nslices     32 of thickness "));
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn the_parts_of_the_time_are_in_the_whole() {
    let desk = Desk::cold(); // the field and the program are computed
    let said = desk.good(&format!("render dodecahedron --effect fur --resolution 64 --module weights=cubic {SMALL}"));
    let line = said.lines().find(|line| line.starts_with("time ")).unwrap();
    let ms = |behind: &str| -> f64 {
        let number = line.split_once(behind).unwrap_or_else(|| panic!("no `{behind}`: {line}")).0;
        number.rsplit([' ', '(']).next().unwrap().parse().unwrap()
    };
    let [load, compile, all] = [" ms to load", " ms to compile", " ms in all"].map(ms);
    let field = said.split_once("computed in ").and_then(|(_, rest)| rest.split_once(" ms")).unwrap().0;
    // Each is rounded to a millisecond.
    assert!(load >= field.parse::<f64>().unwrap() - 1.0 && load + compile <= all + 1.5, "{said}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn what_changes_nothing_is_said_in_one_line() {
    let desk = Desk::new();
    let ignored = |arguments: &str| {
        let out = desk.good(&format!("render {arguments} --size 24x24 --samples 16"));
        let line = out.lines().find(|line| line.starts_with("ignored ")).unwrap_or_default();
        line.trim_start_matches("ignored").split(": the picture").next().unwrap_or_default().trim().to_string()
    };
    assert_eq!(ignored("torus --gradient central --seed 3"), "effect.gradient = \"central\", quality.seed = 3");
    assert_eq!(ignored("torus --effect fire --set effect.octaves=6 --time 2"), "effect.octaves = 6");
    assert_eq!(
        ignored("torus --pass march --order back_to_front --target unorm8"),
        "quality.order = \"back_to_front\""
    );
    assert_eq!(ignored("torus --effect shells --shadows"), "light.shadows = true");
    assert_eq!(ignored("fire_ball"), "", "what a preset sets is not said");
    assert_eq!(ignored("torus --depth 16 -o a.exr"), "--depth 16");
    for (effect, gradient) in [("fire", "three"), ("fire", "central"), ("fur", "three"), ("fur", "central")] {
        let said = ignored(&format!("torus --effect {effect} --gradient {gradient}"));
        assert_eq!(said, format!("effect.gradient = \"{gradient}\""), "{effect} reads no normal of soft matter");
    }
    assert_eq!(ignored("torus --effect woven --gradient three"), "", "cloth reads it");
    assert_eq!(ignored("torus --effect lit --set animation.loop=5"), "animation.loop = 5.0");
    let out = desk.good("render torus --module dmf=biased --set density_bias=0.7 --size 24x24 --samples 16");
    assert!(out.contains("dmf=biased") && !out.contains("ignored"), "a DMF makes a hard object soft: {out}");
    fs::write(desk.file("scene.toml"), "preset = \"fire\"\nobject.input = \"torus\"\nquality.seed = 4\n").unwrap();
    assert_eq!(ignored("scene.toml"), "quality.seed = 4");
    let out = desk.good("render torus --effect fire --size 24x24 --samples 16");
    assert!(out.contains("octaves    4 of 8: a block of 64 texels and 4 cells along a side holds no more"), "{out}");
    let out = desk.good("render torus --effect fire --set quality.turbulence_cells=1 --size 24x24 --samples 16");
    assert!(out.contains("octaves    6 of 8: "), "{out}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn final_pictures_are_supersampled_by_default() {
    let desk = Desk::new();
    desk.write("one.toml", "preset = \"lit\"\nobject.input = \"sphere\"\nquality.supersampling = 1\n");
    desk.write("open.toml", "preset = \"lit\"\nobject.input = \"sphere\"\nquality.samples = 48\n");
    // Pixels of the outline that are neither clear nor opaque.
    let edges = |arguments: &str| {
        desk.good(&format!("render {arguments} {SMALL} -o x.png --save-scene s.toml"));
        let saved = hypertexture::scene::load(&desk.file("s.toml"), Reach::Anywhere).unwrap();
        let pixels = image::open(desk.file("x.png")).unwrap().to_rgba8();
        (saved.quality.supersampling, pixels.pixels().filter(|pixel| (8..248).contains(&pixel[3])).count())
    };
    for (arguments, rays) in [("sphere", 4), ("open.toml", 4), ("sphere --supersampling 2", 2)] {
        let (saved, smooth) = edges(arguments);
        assert!(saved == rays && smooth > 40, "{arguments}: {saved} rays, {smooth} pixels");
    }
    for arguments in ["one.toml", "sphere --supersampling 1", "sphere --set quality.msaa=1"] {
        assert_eq!(edges(arguments), (1, 0), "{arguments}");
    }
    // A picture says how it was made.
    desk.good(&format!("render one.toml {SMALL} -o one.png"));
    assert_eq!(edges("one.png"), (1, 0));
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn an_empty_picture_says_why() {
    let desk = Desk::new();
    desk.write("flat.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
    let empty = |arguments: &str| {
        let out = desk.good(&format!("render {arguments} {SMALL}"));
        out.lines().find(|line| line.starts_with("empty ")).unwrap_or_default().to_string()
    };
    let flat = empty("flat.obj");
    assert!(flat.contains("no voxel is inside of the object") && flat.contains("--resolution"), "{flat}");
    let remedy = flat.split_once("--shell").unwrap().1;
    assert_eq!(empty(&format!("flat.obj --shell {remedy}")), "", "the remedy shows it");
    assert!(empty("torus --clip 0,0,1,-2").contains("no ray meets matter"));
    assert_eq!(empty("torus"), "");
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_surface_becomes_a_mesh_that_is_rendered_as_the_object() {
    let desk = Desk::new();
    for end in ["stl", "ply", "obj", "glb", "3mf"] {
        let out = desk.good(&format!("mesh torus -o torus.{end} --grid 40"));
        assert!(out.contains("1 body; watertight") && out.contains("size       1.999"), "{out}");
        let told = desk.good(&format!("info torus.{end}"));
        assert!(told.contains("bodies     1") && told.contains("0 open, 0 crowded, 0 turned"), "{told}");
        desk.good(&format!("convert torus.{end} -o again.ply"));
    }
    let same = desk.good("convert torus.glb -o other.obj");
    assert!(same.starts_with("mesh "), "{same}");
    desk.good(&format!("render other.obj -o other.png {SMALL}"));
    desk.good(&format!("render torus -o torus.png {SMALL}"));
    let [other, own] = ["other.png", "torus.png"].map(|name| image::open(desk.file(name)).unwrap().to_rgba8());
    let seen = |image: &image::RgbaImage| image.pixels().filter(|pixel| pixel[3] > 0).count() as f64;
    assert!((seen(&other) / seen(&own) - 1.0).abs() < 0.05, "{} {}", seen(&other), seen(&own));
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn layers_of_a_scan_have_an_iso_value_each() {
    let desk = Desk::new();
    desk.good("convert head -o scan.nrrd");
    let output = desk.run(&format!("render scan.nrrd --effect anatomy --resolution 48 -o a.png {SMALL}"));
    let said = text(&output.stdout) + &text(&output.stderr);
    assert!(said.contains("no iso-value was given") && said.contains("bone of"), "{said}");
    desk.good(&format!("render scan.nrrd --effect anatomy --iso 0.5,1.5 --resolution 48 -o b.png {SMALL}"));
    desk.good(&format!("render head --effect anatomy --resolution 48 -o c.png {SMALL}"));
    let [brought, own] = ["b.png", "c.png"].map(|name| image::open(desk.file(name)).unwrap().to_rgba8());
    assert_eq!(brought, own, "the same volume");
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_quiet_render_says_nothing() {
    let desk = Desk::new();
    assert_eq!(desk.good(&format!("render torus --quiet -o x.png {SMALL}")), "");
    assert_eq!(size_of(&desk.file("x.png")), (64, 64));
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_closed_standard_output_is_no_error() {
    let desk = Desk::new();
    for arguments in ["effects", "--help", &format!("render torus -o x.png {SMALL}")] {
        let mut child = desk.command(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        assert!(output.status.success(), "`{arguments}`: {}", output.status);
        assert_eq!(text(&output.stderr), "", "`{arguments}`");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_saved_scene_gives_the_same_picture() {
    let desk = Desk::new();
    let look = "--effect fire --set fury=1.5 --camera 10,20,1.2 --clip 0,0,1,0.4 --background #203040";
    desk.good(&format!("render torus {look} {SMALL} -o first.png --save-scene s.toml"));
    desk.good("render s.toml -o second.png");
    assert_eq!(fs::read(desk.file("first.png")).unwrap(), fs::read(desk.file("second.png")).unwrap());
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_preset_module_with_parameters_can_be_exchanged() {
    let said = Desk::new().good(&format!("render torus --effect fire --module medium=lit --set fury=1 {SMALL}"));
    assert!(said.contains("medium=lit"), "{said}");
}

const SWELL: &str = "// A power of the density.
// Source: none.
// density: in [0, 1]; result in [0, 1].
// @outer swell_width
// @param swell_width = 0.3 in [0.01, 1]: Width of the soft region, object units.
// @param swell_power = 0.5 in [0.1, 4]: The power.
float swell(float density, Sample s) { return pow(density, swell_power); }
";

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_module_of_ones_own_is_used_as_one_that_ships() {
    let desk = Desk::new();
    desk.write("swell.glsl", SWELL);
    let look = SMALL;
    desk.good(&format!("render sphere {look} -o plain.png"));
    let said =
        desk.good(&format!("render sphere --dmf swell.glsl --set swell_power=3 {look} -o own.png --save-scene s.toml"));
    assert!(said.contains("dmf=swell") && said.contains("linked for it"), "{said}");
    desk.good("render s.toml -o again.png");
    let [plain, own, again] = ["plain.png", "own.png", "again.png"].map(|name| fs::read(desk.file(name)).unwrap());
    assert!(plain != own && own == again);
    let said = desk.good(&format!("render sphere --dmf swell.glsl {look} -o bound.png --max-error 0.05"));
    assert!(said.contains("dmf=swell") && said.contains("f64 reference"), "{said}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_module_of_ones_own_that_is_wrong_is_refused_at_its_line() {
    let broken = |desk: &Desk| {
        desk.write("swell.glsl", SWELL.replace("pow(density, swell_power)", "pow(density, swell_powr)"));
        desk.write("other.glsl", SWELL);
    };
    refused(
        broken,
        &[
            ("render sphere -o out.png --dmf swell.glsl", &["swell", "7", "swell_powr"]),
            ("render sphere -o out.png --dmf other.glsl", &["other"]),
            ("render sphere -o out.png --dmf absent.glsl", &["absent.glsl"]),
        ],
    );
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn custom_modules_with_nan_or_endless_loops_are_named() {
    let with =
        |desk: &Desk, body: &str| desk.write("swell.glsl", SWELL.replace("return pow(density, swell_power);", body));
    let desk = Desk::new();
    with(&desk, "return density * log(s.x.x);");
    let said = desk.good(&format!("render sphere --dmf swell.glsl {SMALL} -o own.png"));
    let line = said.lines().find(|line| line.starts_with("module ")).unwrap();
    assert!(line.contains("dmf/swell.glsl gives NaN with swell_width = 0.3, swell_power = 0.5, for "), "{line}");
    let hot = |desk: &Desk| desk.write("hot.glsl", "vec3 medium(Sample s, float density) { return vec3(log(s.x.y)); }");
    let line = format!("render sphere -o out.png --effect fur --module medium=hot.glsl {SMALL}");
    refused(hot, &[(&line, &["medium/hot.glsl gives NaN"])]);
    let endless = |desk: &Desk| with(desk, "for (;;) density = fract(1.1 * density + s.x.x); return density;");
    let parts = ["dmf/swell.glsl:7", "more than 65535 turns with swell_width = 0.3, swell_power = 0.5", "end the loop"];
    refused(endless, &[(&format!("render sphere -o out.png --dmf swell.glsl {SMALL}"), &parts)]);
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn the_fastest_settings_within_an_error_is_drawn_and_remembered() {
    let desk = Desk::new();
    let first = desk.good(&format!("render lit -o a.png --max-error 0.03 --metric p999 {SMALL}"));
    assert!(first.contains("asked for 3e-2") && !first.contains("remembered"), "{first}");
    let second = desk.good(&format!("render lit -o b.png --max-error 0.03 --metric p999 {SMALL}"));
    assert!(second.contains("remembered"), "{second}");
    assert_eq!(fs::read(desk.file("a.png")).unwrap(), fs::read(desk.file("b.png")).unwrap());
    let rows: [(&str, &[&str]); 3] = [
        ("render lit -o out.png --max-error 1e-12 --size 16x16", &["no settings", "1e-12", "the nearest"]),
        ("render lit -o out.png --max-error 0", &["must be above 0"]),
        ("render lit -o out.png --max-error 0.1 --metric beauty", &["beauty", "rmse"]),
    ];
    refused(|_| (), &rows);
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_parameter_of_one_object_is_set_by_its_name() {
    let desk = Desk::new();
    let small = "--size 32x32 --samples 32";
    for (set, name) in [("", "as_is.png"), ("--set parts.stone.distortion=4", "stone.png")] {
        desk.good(&format!("render ensemble {set} {small} -o {name}"));
    }
    assert!(fs::read(desk.file("as_is.png")).unwrap() != fs::read(desk.file("stone.png")).unwrap());
    refused(
        |_| (),
        &[
            ("render ensemble -o out.png --set parts.ston.distortion=4", &["ston", "stone"]),
            ("render ensemble -o out.png --set parts.stone.distorsion=4", &["distorsion", "distortion"]),
        ],
    );
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn an_exr_and_a_png_of_16_bits_are_written_by_their_names() {
    let desk = Desk::new();
    desk.good(&format!("render sphere -o x.exr {SMALL}"));
    desk.good(&format!("render sphere -o x.png --depth 16 {SMALL}"));
    let exr = image::open(desk.file("x.exr")).unwrap();
    assert_eq!((exr.width(), exr.height(), exr.color()), (64, 64, image::ColorType::Rgba32F));
    assert_eq!(image::open(desk.file("x.png")).unwrap().color(), image::ColorType::Rgba16);
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn the_field_of_a_torus_renders_as_the_torus() {
    let desk = Desk::new();
    desk.good("field torus -o f.nrrd --resolution 64");
    desk.good(&format!("render f.nrrd -o field.png {SMALL}"));
    desk.good(&format!("render torus -o formula.png {SMALL}"));
    let [field, formula] = ["field.png", "formula.png"].map(|name| image::open(desk.file(name)).unwrap().to_rgba8());
    let differs = |(a, b): &(&image::Rgba<u8>, &image::Rgba<u8>)| a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > 40);
    let different = field.pixels().zip(formula.pixels()).filter(differs).count();
    // The outline is found to half a voxel, 1/64 of the object: at most the pixels along it differ.
    assert!(different < 64 * 64 / 10, "{different} pixels differ");
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_gallery_has_six_pictures_and_a_page_that_names_them() {
    let desk = Desk::new();
    desk.good(&format!("gallery torus -o dir {SMALL}"));
    let page = fs::read_to_string(desk.file("dir/index.html")).unwrap();
    for effect in ["lit", "solid", "bump", "fur", "melting", "fire"] {
        assert_eq!(size_of(&desk.file(&format!("dir/{effect}.png"))), (64, 64));
        assert!(page.contains(&format!("{effect}.png")), "the page does not show {effect}");
    }
    assert_eq!(desk.files().len(), 7);
}

/// The command lines of a gallery's page, each as the shell runs it in a folder.
fn commands_of(page: &str) -> Vec<String> {
    let lines = page.split("<code>hypertexture ").skip(1).map(|rest| rest.split_once("</code>").unwrap().0);
    lines
        .map(|line| line.replace("&quot;", "\"").replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&"))
        .collect()
}

#[cfg(unix)]
#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn commands_of_the_gallery_make_its_pictures() {
    let desk = Desk::new();
    desk.write("my 'new' <box>.obj", BOX);
    let mut command = desk.command("gallery --size 40x24 --samples 20 --resolution 24 --up z -o dir");
    assert!(command.arg("my 'new' <box>.obj").status().unwrap().success());
    let commands = commands_of(&fs::read_to_string(desk.file("dir/index.html")).unwrap());
    assert_eq!(commands.len(), 6);
    for command in commands {
        let mut shell = desk.shell(&format!("{} {command}", env!("CARGO_BIN_EXE_hypertexture")));
        let output = shell.output().unwrap();
        assert!(output.status.success(), "{command}: {}", text(&output.stderr));
        let file = command.rsplit(' ').next().unwrap();
        let [shown, made] = [format!("dir/{file}"), file.into()].map(|file| fs::read(desk.file(&file)).unwrap());
        assert!(shown == made, "{command}: another file");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p58_a_gallery_without_an_object_groups_figures_by_paper() {
    let desk = Desk::new();
    desk.good("gallery --size 16x16 --samples 16 --resolution 24");
    let page = fs::read_to_string(desk.file("out/index.html")).unwrap();
    for name in hypertexture::scene::names() {
        assert_eq!(size_of(&desk.file(&format!("out/{name}.png"))), (16, 16));
        assert!(page.contains(&format!("hypertexture render {name} ")), "no command for {name}");
    }
    let place = |text: &str| page.find(text).unwrap_or_else(|| panic!("`{text}` is not on the page"));
    assert!(place("<h2>Miller and Jones 2005") < place("id=\"fur\""));
    assert!(place("id=\"fur\"") < place("<h2>Perlin and Hoffert 1989"));
    assert!(place("<h2>Perlin and Hoffert 1989") < place("id=\"noisy_sphere\""));
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_figure_is_rendered_by_name_and_takes_another_effect() {
    let desk = Desk::new();
    desk.good(&format!("render noisy_sphere -o x.png --save-scene s.toml {SMALL}"));
    let saved = hypertexture::scene::load(&desk.file("s.toml"), Reach::Anywhere).unwrap();
    let preset = hypertexture::scene::preset("noisy_sphere").unwrap();
    assert_eq!((saved.object, saved.effect, saved.camera), (preset.object, preset.effect, preset.camera));
    desk.good(&format!("render furry_donut --effect lit -o y.png --save-scene t.toml {SMALL}"));
    let saved = hypertexture::scene::load(&desk.file("t.toml"), Reach::Anywhere).unwrap();
    assert_eq!((saved.object.input.as_str(), saved.effect.surface.as_str()), ("torus", "lit"));
    assert!(saved.effect.dmf.is_empty());
}

#[test]
fn every_effect_is_listed_with_its_parameters() {
    let said = Desk::new().good("effects");
    for name in hypertexture::scene::names() {
        let scene = hypertexture::scene::preset(name).unwrap();
        assert!(said.contains(&format!("{name}: {}", scene.about)), "{name} is not listed");
        let about = said.split_once(&format!("{name}: ")).unwrap_or_default().1;
        for (parameter, value) in scene.check(&hypertexture::shader::shipped()).unwrap().iter() {
            let line = about.lines().find(|line| line.trim_start().starts_with(&format!("{} ", parameter.name)));
            let line = line.unwrap_or_else(|| panic!("{} of {name} is not listed", parameter.name));
            let value = match value {
                ParameterValue::Number(number) => number.to_string(),
                ParameterValue::Color(color) => String::from(*color),
            };
            assert!(line.contains(&format!(" {value} ")) && line.ends_with(&parameter.doc), "{line}: expected {value}");
        }
    }
}

#[test]
fn help_and_version_succeed() {
    let desk = Desk::new();
    for arguments in ["-h", "--help", "render -h", "field -h", "gallery --help", "help", "help render"] {
        assert!(desk.good(arguments).contains("Usage: hypertexture"), "{arguments}");
    }
    let [short, all] = ["render -h", "render --help"].map(|line| desk.good(line));
    assert!(short.lines().count() <= 30 && short.contains("Examples:") && !short.contains("--restart"), "{short}");
    assert!(all.contains("--restart"), "{all}");
    assert_eq!(desk.good("--version"), format!("hypertexture {}\n", env!("CARGO_PKG_VERSION")));
}

#[test]
fn completions_and_manual_pages_know_commands_and_arguments() {
    let desk = Desk::new();
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = desk.good(&format!("completions {shell}"));
        assert!(["gallery", "max-error"].iter().all(|word| script.contains(word)), "{shell}");
        assert!(!script.contains("requests of the parent"), "{shell} completes a hidden command");
    }
    let program = desk.good("man");
    assert!(program.contains(".TH hypertexture 1") && program.contains("hypertexture\\-render(1)"), "{program}");
    let render = desk.good("man render");
    assert!(render.contains(".TH hypertexture-render 1") && render.contains("\\-\\-turntable"), "{render}");
    assert!(!program.contains("hypertexture\\-job(1)"), "{program}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn an_object_thinner_than_a_voxel_gets_advice_that_works() {
    let desk = Desk::new();
    let needle = BOX.replace(".5", ".00005").replace(".25", ".00005");
    desk.write("needle.obj", &needle);
    let mut line = b"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1 1 32\nencoding: raw\n\n".to_vec();
    line.extend((0..32).map(|z| if (8..24).contains(&z) { 200u8 } else { 0 }));
    fs::write(desk.file("line.nrrd"), line).unwrap();
    for input in ["needle.obj", "line.nrrd --iso 100"] {
        let said = desk.good(&format!("render {input} {SMALL}"));
        let empty = said.lines().find(|line| line.starts_with("empty ")).unwrap_or_else(|| panic!("{input}: {said}"));
        assert!(empty.contains("thinner than one"), "{input}: {empty}");
        match empty.split_once("--shell") {
            Some((_, remedy)) => {
                let said = desk.good(&format!("render {input} --shell {remedy} {SMALL}"));
                assert!(!said.contains("\nempty "), "{input}: the remedy shows it: {said}");
            }
            None => assert!(empty.contains("several voxels across"), "{input}: {empty}"),
        }
    }
    let said = desk.good(&format!("render sphere --effect lit --shell 1e-9 {SMALL}"));
    assert!(said.contains("no resolution prevents them") && said.contains("the finest, 1024"), "{said}");
    let face = "v 0 0 0\nv 1e-40 0 0\nv 0 1e-40 0\nv 0 0 1e-40\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    let rows: [(&str, &[&str]); 1] = [("render tiny.obj -o out.png", &["tiny.obj", "1e-37 or more"])];
    refused(|desk: &Desk| desk.write("tiny.obj", face), &rows);
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn an_eye_in_hard_matter_is_told() {
    let desk = Desk::new();
    let told =
        |arguments: &str| desk.good(&format!("render {arguments} {SMALL}")).contains("the eye is inside hard matter");
    assert!(told("sphere --effect lit --camera 0,0,100"));
    assert!(told(
        "sphere --set effect.classify=soft --set effect.softness=linear --set object.outer_iso=0.3 --camera 0,0,20"
    ));
    assert!(!told("sphere --effect lit"));
    assert!(!told("sphere --effect lit --camera 0,0,100 --clip 0,0,1,-0.5"), "the eye is in what is cut away");
    let soft = "--set effect.classify=soft --set effect.softness=quadratic";
    let said =
        desk.good(&format!("render sphere {soft} --set object.inner_iso=-2 --set object.outer_iso=-1.5 {SMALL}"));
    assert!(said.contains("\nempty "), "no place is that deep: {said}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn an_unchanged_pipeline_cache_is_not_written_again() {
    let desk = Desk::new();
    let files = || -> Vec<(std::path::PathBuf, std::time::SystemTime)> {
        let folder = fs::read_dir(desk.file("..").join("cache")).into_iter().flatten().flatten();
        let all = folder.filter(|file| file.file_name().to_string_lossy().starts_with("pipelines-"));
        all.map(|file| (file.path(), file.metadata().unwrap().modified().unwrap())).collect()
    };
    desk.good(&format!("render torus {SMALL}"));
    let first = files();
    desk.good(&format!("render torus {SMALL}"));
    assert_eq!(files(), first);
    assert!(first.iter().all(|(path, _)| fs::metadata(path).unwrap().len() > 128), "a header alone helps nobody");
}
