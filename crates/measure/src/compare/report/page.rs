//! Reports by template.

use crate::compare::digits::short;
use crate::compare::metrics::FLIP;
use minijinja::{Environment, UndefinedBehavior};
use serde_json::Value;

const TEMPLATES: [(&str, &str); 8] = [
    ("about.md", include_str!("about.md")),
    ("page.html", include_str!("page.html")),
    ("parts.html", include_str!("parts.html")),
    ("chart.html", include_str!("chart.html")),
    ("compare.html", include_str!("compare.html")),
    ("paper.html", include_str!("paper.html")),
    ("paper.md", include_str!("paper.md")),
    ("stress.html", include_str!("stress.html")),
];

/// A report as one of the templates shows it.
pub fn page(template: &str, report: &Value) -> String {
    let mut environment = Environment::new();
    // A missing value fails a test; for a user, it is a gap in a report that took minutes.
    let undefined = if cfg!(test) { UndefinedBehavior::SemiStrict } else { UndefinedBehavior::Lenient };
    environment.set_undefined_behavior(undefined);
    environment.add_global("flip", FLIP);
    environment.add_filter("short", |value: Option<f64>| value.map_or("–".into(), short));
    environment.add_filter("fixed", |value: Option<f64>| value.map_or("–".into(), |value| format!("{value:.2}")));
    for (name, text) in TEMPLATES {
        environment.add_template(name, text).expect("the syntax of the templates is tested");
    }
    let context = minijinja::value::Serde(report);
    let page = environment.get_template(template).and_then(|page| page.render(context));
    // A slash is harmless in a page, and half of a picture.
    page.expect("the templates are tested").replace("&#x2f;", "/") + "\n"
}
