//! Shared parts of all pages: frame, formats of text and numbers, and the measuring environment.

use super::Environment;
use crate::compare::metrics::FLIP;
use crate::compare::timing::Spread;

const PAGE: &str = include_str!("page.html");

/// A page of this style with a body.
pub fn whole(title: &str, body: &str) -> String {
    PAGE.replace("{title}", &escape(title)).replace("{body}", body)
}

/// Text as it may stand in a page.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// A number with three digits, as a power of ten where it is small or large.
pub fn short(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    if !value.is_finite() {
        return if value > 0.0 { "∞".into() } else { "–".into() };
    }
    let power = value.abs().log10().floor() as i32;
    match power {
        -3..=3 => format!("{value:.*}", (2 - power).max(0) as usize),
        _ => format!("{:.2}·10<sup>{power}</sup>", value / 10f64.powi(power)),
    }
}

/// A time with its interval.
pub fn spread(time: &Spread) -> String {
    let mark = if time.is_unsteady() { " <abbr title=\"95th percentile above 1.25 medians\">≋</abbr>" } else { "" };
    let [low, high] = time.interval;
    format!("{} <small>[{}, {}]</small>{mark}", short(time.median), short(low), short(high))
}

/// Where and when it was measured, as a list.
pub fn circumstances(e: &Environment, more: &[(&str, String)]) -> String {
    let load = |load: Option<f64>| load.map_or("unknown".into(), |load| format!("{load:.2}"));
    let variables: Vec<String> = e.variables.iter().map(|(name, value)| format!("{name}={value}")).collect();
    let entries = [
        ("device", format!("{}, {}, Vulkan {}", e.device, e.driver, e.vulkan)),
        ("processor", format!("{}, {} threads", e.processor.as_deref().unwrap_or("unknown"), e.threads)),
        ("load average", format!("{} before, {} after", load(e.load_before), load(e.load_after))),
        ("clock", e.governor.clone().unwrap_or_else(|| "governor unknown".into())),
        ("system", e.system.clone()),
        ("variables", if variables.is_empty() { "none set".into() } else { variables.join(", ") }),
        ("program", format!("hypertexture {}; FLIP by {FLIP}", e.version)),
        ("date", e.date.clone()),
        ("command line", e.command.clone()),
    ];
    let all = entries.iter().chain(more);
    let list: Vec<String> = all.map(|(name, value)| format!("<dt>{name}<dd>{}", escape(value))).collect();
    format!("<dl>\n{}\n</dl>\n", list.join("\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits() {
        let written = [0.0, 1.0, 12.345, 0.001234, 1.2e-5, 43210.0, f64::INFINITY].map(short);
        assert_eq!(written, ["0", "1.00", "12.3", "0.00123", "1.20·10<sup>-5</sup>", "4.32·10<sup>4</sup>", "∞"]);
    }
}
