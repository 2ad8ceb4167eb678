//! `info`: the contents of a mesh, a volume or a groom.

use crate::terminal::{say, say_json};
use clap::Args;
use hypertexture::shape::{Facts, Groom, Histogram};
use hypertexture_support::{quoted, significant, words};
use serde_json::json;
use std::error::Error;
use std::path::Path;

/// Rows of the histogram.
const ROWS: usize = 16;
/// Characters of its longest bar.
const BAR: f64 = 40.0;

/// Arguments of `info`.
#[derive(Args)]
pub(crate) struct Info {
    /// A mesh, a volume, a groom or a built-in object.
    pub input: String,
    /// The grid of an OpenVDB file with several.
    #[arg(long, value_name = "NAME")]
    pub grid: Option<String>,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}

/// Reads and describes a file.
pub(crate) fn run(command: &Info) -> Result<(), Box<dyn Error>> {
    let found = Facts::of(&command.input, command.grid.as_deref());
    // A groom is a NRRD file, but not a volume.
    let groom = if found.is_err() { Groom::read(Path::new(&command.input)).ok() } else { None };
    let facts = match &groom {
        Some(groom) => Facts::of_groom(groom),
        None => found?,
    };
    if command.json {
        let mut all = json!({ "file": command.input });
        for fact in &facts.lines {
            all[fact.name] = fact.value.clone();
        }
        if let Some(histogram) = &facts.histogram {
            all["histogram"] = json!({
                "from": histogram.range.0, "to": histogram.range.1,
                "voxels": histogram.counts, "mean_gradient": histogram.gradients,
            });
        }
        return Ok(say_json(&all)?);
    }
    let mut text: String =
        facts.lines.iter().map(|fact| format!("{:<11}{}\n", fact.name, words::line(&fact.words))).collect();
    if let Some(histogram) = &facts.histogram {
        text += &format!("histogram  {}\n", chart(histogram));
    }
    // The flag that chooses the surface of the picture.
    let flag = match facts.iso_values.first() {
        _ if facts.is_like_distances => " --distance".into(),
        Some(iso) => format!(" --iso {iso}"),
        None => String::new(),
    };
    let (input, part) = match (&groom, &command.grid) {
        (Some(groom), _) => (&groom.object, format!(" --effect fur --groom {}", quoted(&command.input))),
        (None, Some(grid)) => (&command.input, format!(" --grid {}", quoted(grid))),
        (None, None) => (&command.input, String::new()),
    };
    text += &format!(
        "picture    hypertexture render {} -o picture.png{flag}{}\n",
        words::line(&quoted(input)),
        words::line(&part)
    );
    say(&text);
    Ok(())
}

/// Histogram: bars of the logarithm of the number of voxels, and the mean gradient.
fn chart(histogram: &Histogram) -> String {
    let each = histogram.counts.len() / ROWS;
    let (low, high) = (f64::from(histogram.range.0), f64::from(histogram.range.1));
    let rows: Vec<(u64, f64)> = (0..ROWS)
        .map(|row| {
            let own = row * each..(row + 1) * each;
            let count = histogram.counts[own.clone()].iter().sum::<u64>();
            let change = own.map(|bin| histogram.counts[bin] as f64 * histogram.gradients[bin]).sum::<f64>();
            (count, change / count.max(1) as f64)
        })
        .collect();
    let most = rows.iter().map(|(count, _)| *count).max().unwrap_or(1).max(2);
    let line = |(row, (count, change)): (usize, &(u64, f64))| {
        let from = significant(low + (high - low) * row as f64 / ROWS as f64, 5);
        let bar = (((count + 1) as f64).ln() / (most as f64).ln() * BAR).round() as usize;
        format!("\n  {from:>12} {:<41} {count}, change {}", "#".repeat(bar), significant(*change, 4))
    };
    format!(
        "voxels from each value on (logarithmic), and their mean change to the next{}",
        rows.iter().enumerate().map(line).collect::<String>()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_histogram_shows_the_ends_of_f32_and_small_values() {
        for scale in [1.0e-6f32, f32::MAX] {
            let histogram =
                Histogram { range: (-scale, scale), counts: vec![3; 64], gradients: vec![0.25 * f64::from(scale); 64] };
            let chart = chart(&histogram);
            assert!(!chart.contains("inf") && !chart.contains("NaN"), "{chart}");
            let from: Vec<f64> =
                chart.lines().skip(1).map(|line| line.split_whitespace().next().unwrap().parse().unwrap()).collect();
            let expected = |row: usize| f64::from(scale) * (row as f64 / 8.0 - 1.0);
            assert!(
                from.iter().enumerate().all(|(row, from)| (from - expected(row)).abs() <= 1e-4 * f64::from(scale)),
                "{chart}"
            );
        }
    }
}
