//! Facts about the device, remedies for missing features, and results of self-tests.
//!
//! Role: device facts, remedies for missing features, and self-tests of known driver faults. Invariant: every failure is a line of
//! the report.

use super::finding::Diagnosis;
use super::probes;
use hypertexture::gpu::{Format, Gpu, GpuError, Options};
use hypertexture::output::PROGRAM;

/// Formats that targets are blended in.
const TARGETS: [Format; 3] = [Format::Rgba8Unorm, Format::Rgba16Float, Format::Rgba32Float];

/// Examines the chosen device in less than two seconds.
///
/// A device that cannot be opened is a finding with its remedy.
pub fn examine(options: &Options) -> Diagnosis {
    let mut report = Diagnosis { program: PROGRAM, healthy: true, findings: Vec::new() };
    match Gpu::new(options) {
        Ok(gpu) => {
            report.info(&gpu);
            report.formats(&gpu);
            report.surroundings(options);
            probes::run(&gpu, &mut report);
        }
        Err(error) => {
            report.surroundings(options);
            report.line("FAIL", &error.to_string());
        }
    }
    report
}

impl Diagnosis {
    fn info(&mut self, gpu: &Gpu) {
        let info = gpu.info();
        self.line("device", &info.name);
        self.line("driver", &info.driver);
        self.line("api", &format!("Vulkan {}", info.api));
        self.line("volumes", &format!("up to {} texels along a side", info.max_volume));
        self.line("images", &format!("up to {} pixels along a side", info.max_image));
        self.line("sampled", &format!("up to {} images in one program", info.max_sampled_images));
        let counts = gpu.sample_counts(Format::Rgba32Float).iter().map(u32::to_string).collect::<Vec<_>>().join(", ");
        self.line("samples", &format!("{counts} per pixel of a float32 target"));
        self.line("anisotropy", &format!("up to {}", info.max_anisotropy));
        match info.timestamp_period {
            0.0 => self.line("timestamps", "none: times are those of the wall clock"),
            period => self.line("timestamps", &format!("{period} ns for each tick")),
        }
        let counted = if info.counts_fragments { "counted" } else { "not counted: the device has no such query" };
        self.line("fragments", counted);
        if info.cpu {
            let remedy = "this device is a CPU, and slow; where there is a GPU, install Mesa's Vulkan drivers";
            self.line("NOTE", &format!("{remedy} (AMD, Intel), or the driver of its vendor"));
        }
        if !info.sample_shading {
            self.line("NOTE", "no sample shading: --msaa 2 to 8 are refused; use --msaa 1 and a larger --size");
        }
    }

    fn formats(&mut self, gpu: &Gpu) {
        let named = |formats: &[Format], can: &dyn Fn(Format) -> bool| {
            let able = formats.iter().filter(|format| can(**format));
            able.map(|format| format!("{format:?}")).collect::<Vec<_>>().join(", ")
        };
        self.line("blends", &named(&TARGETS, &|format| gpu.can_blend(format)));
        self.line("filters", &named(&Format::SAMPLED, &|format| gpu.can_filter(format)));
        for format in TARGETS.into_iter().filter(|format| !gpu.can_blend(*format)) {
            // Only the default target is required.
            let what = if format == Format::Rgba32Float { "FAIL" } else { "NOTE" };
            self.line(what, &format!("{format:?} cannot be blended into: use another --target"));
        }
        for format in &gpu.info().unread {
            self.line("NOTE", &format!("{format:?} cannot be read: its texels are stored as 32-bit floats"));
        }
        for format in &gpu.info().unfiltered {
            let (what, remedy) = match format {
                Format::R16Unorm | Format::Rgba16Unorm => {
                    ("NOTE", "volumes and tables are drawn by --filter exact, which is slower; --anisotropy is refused")
                }
                Format::R32Float => (
                    "NOTE",
                    "blocks of noise have 16 bits; --field-encoding distance32 is drawn by --filter exact, slower",
                ),
                Format::Rgba32Float => (
                    "NOTE",
                    "half-angle light and classify = preintegrated are drawn by --filter exact, which is slower",
                ),
                // Vulkan requires these.
                _ => ("FAIL", "update the driver, or HYPERTEXTURE_DEVICE=llvmpipe"),
            };
            self.line(what, &format!("{format:?} cannot be filtered: {remedy}"));
        }
    }

    fn surroundings(&mut self, options: &Options) {
        match Gpu::new(&Options { validation: true, cache: None, device: options.device.clone() }) {
            Ok(_) => self.line("validation", "the layer is installed; HYPERTEXTURE_VALIDATION=1 turns it on"),
            Err(GpuError::NoValidation) => {
                self.line(
                    "validation",
                    "not installed, and needed for tests only: vulkan-validationlayers, or on Fedora and Arch \
                     vulkan-validation-layers",
                );
            }
            Err(_) => self.line("validation", "unknown: there is no device to ask"),
        }
        match (hypertexture_support::disk_cache::default_folder(), &options.cache) {
            (None, None) => {
                self.line("caches", "nowhere, so that every start is slow: export HYPERTEXTURE_CACHE=/tmp/hypertexture")
            }
            (fields, pipelines) => {
                let shown = |folder: &Option<std::path::PathBuf>| match folder {
                    Some(folder) => format!("in {}", folder.display()),
                    None => "not kept".into(),
                };
                self.line("caches", &format!("distance fields {}; pipelines {}", shown(&fields), shown(pipelines)));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hypertexture_support::validation_lock::ValidationLock;

    #[test]
    #[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
    fn the_device_of_the_tests_is_healthy_and_named() {
        let _alone = ValidationLock::acquire();
        let start = std::time::Instant::now();
        let report = examine(&Options::from_env());
        println!("{}{:.2} s", report.text(), start.elapsed().as_secs_f64());
        assert!(report.healthy, "{}", report.text());
        let gpu = Gpu::new(&Options::from_env()).unwrap();
        assert!(report.text().contains(&gpu.info().name));
        for subject in ["loops", "filter", "blend", "NaN", "timestamps", "values behind loops", "derivatives", "sines"]
        {
            assert!(report.text().lines().any(|line| line.contains(subject) && line.len() > 30), "{subject}");
        }
        let missed = report.findings.iter().any(|own| own.finding.contains("compute shaders draw bent rays"));
        assert_eq!(missed, gpu.info().misses_neighbors(), "the driver is known by its name and by its pixels");
    }

    #[test]
    #[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
    fn the_self_tests_are_valid_vulkan() {
        let _alone = ValidationLock::acquire();
        let gpu = Gpu::new(&Options { validation: true, ..Options::from_env() }).unwrap();
        let messages = gpu.messages();
        let mut report = Diagnosis { program: PROGRAM, healthy: true, findings: Vec::new() };
        probes::run(&gpu, &mut report);
        drop(gpu);
        assert!(report.healthy, "{}", report.text());
        assert_eq!(messages.take(), [""; 0]);
    }

    #[test]
    fn a_device_that_cannot_be_opened_is_a_finding_with_its_remedy() {
        let _alone = ValidationLock::acquire();
        let report = examine(&Options { device: Some("no such device".into()), ..Options::default() });
        assert!(!report.healthy);
        let failed: Vec<_> = report.findings.iter().filter(|finding| finding.what == "FAIL").collect();
        assert_eq!(failed.len(), 1, "{}", report.text());
        let remedy = &failed[0].finding;
        assert!(remedy.contains("HYPERTEXTURE_DEVICE") || remedy.contains("sudo apt install"), "{remedy}");
    }
}
