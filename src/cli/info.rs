//! `info`: what a file holds, before anything is made of it.

use super::say;
use crate::shape::{Facts, Histogram};
use clap::Args;
use serde_json::json;
use std::error::Error;

/// Rows of the histogram.
const ROWS: usize = 16;
/// Characters of its longest bar.
const BAR: f64 = 40.0;

/// Arguments of `info`.
#[derive(Args)]
pub struct Info {
    /// A mesh, a volume or a built-in object.
    pub input: String,
    /// Everything as JSON.
    #[arg(long)]
    pub json: bool,
}

/// Reads the file, and says what is in it.
pub(super) fn run(command: &Info) -> Result<(), Box<dyn Error>> {
    let facts = Facts::of(&command.input)?;
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
        say(&format!("{}\n", serde_json::to_string_pretty(&all)?));
        return Ok(());
    }
    let mut text: String = facts.lines.iter().map(|fact| format!("{:<11}{}\n", fact.name, fact.words)).collect();
    if let Some(histogram) = &facts.histogram {
        text += &format!("histogram  {}\n", chart(histogram));
    }
    // The flag that says what the surface of the picture is.
    let flag = match facts.iso_values.first() {
        _ if facts.is_like_distances => " --distance".into(),
        Some(iso) => format!(" --iso {iso}"),
        None => String::new(),
    };
    text += &format!("picture    hypertexture render {} -o picture.png{flag}\n", command.input);
    say(&text);
    Ok(())
}

/// Bars as long as the logarithm of the voxels, and how much the values change there.
fn chart(histogram: &Histogram) -> String {
    let each = histogram.counts.len() / ROWS;
    let (low, high) = histogram.range;
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
        let from = low + (high - low) * row as f32 / ROWS as f32;
        let bar = (((count + 1) as f64).ln() / (most as f64).ln() * BAR).round() as usize;
        format!("\n  {from:>10.4} {:<41} {count}, change {change:.3}", "#".repeat(bar))
    };
    format!(
        "voxels from each value on (logarithmic), and their mean change to the next{}",
        rows.iter().enumerate().map(line).collect::<String>()
    )
}
