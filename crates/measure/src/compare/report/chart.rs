//! A chart as SVG: points of error against run time on logarithmic axes, curves, the front and the floor.
//!
//! The colors of ink and paper are CSS variables, so that a page can show the chart in light and dark; [`standalone`]
//! gives them values of its own.

use super::page::escape;
use std::fmt::Write;

/// Mark of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marker {
    /// A ray.
    Circle,
    /// A stack of slices.
    Square,
}

/// Points that belong together, by rising samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Index of its color and of its entry in the legend.
    pub group: usize,
    /// Marks of its points.
    pub marker: Marker,
    /// Whether they are filled.
    pub filled: bool,
    /// Whether it stands behind the others.
    pub faint: bool,
    /// The points.
    pub points: Vec<Point>,
}

/// A measured candidate.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Median time.
    pub time: f64,
    /// Its 95 % interval.
    pub interval: [f64; 2],
    /// Error.
    pub error: f64,
    /// Error of the reference: so far the error may be off.
    pub reference: f64,
    /// Tooltip.
    pub about: String,
}

/// Contents of the chart.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chart {
    /// Description.
    pub title: String,
    /// Names of the groups.
    pub groups: Vec<String>,
    /// The lines, of every group.
    pub lines: Vec<Line>,
    /// Time and error along the front.
    pub front: Vec<(f64, f64)>,
    /// Error of the reference: what lies below says nothing.
    pub floor: Option<f64>,
    /// The clock of the times, such as `on the device`.
    pub clock: &'static str,
}

const SIZE: [f64; 2] = [960.0, 560.0];
/// Height of the title of a chart in a file of its own.
const TITLE: f64 = 36.0;
/// Orders whose slopes are drawn: the time of a curve grows like its samples.
const SLOPES: [i32; 2] = [1, 2];
/// Left, top, right, bottom of the area of the points.
const AREA: [f64; 4] = [78.0, 20.0, 700.0, 500.0];

/// Colors of the groups, legible on white and on black (after Tableau 10).
const COLORS: [&str; 10] =
    ["#4e79a7", "#f28e2b", "#59a14f", "#e15759", "#b07aa1", "#2fa8a0", "#c9a227", "#9c755f", "#e377a2", "#7f8790"];

/// A logarithmic axis.
struct Axis {
    low: f64,
    high: f64,
    from: f64,
    to: f64,
}

impl Axis {
    /// An axis that holds the values with a margin, from one pixel to another.
    fn over(values: impl Iterator<Item = f64>, from: f64, to: f64) -> Axis {
        let positive = values.filter(|value| *value > 0.0 && value.is_finite());
        let (low, high) = positive.fold((f64::INFINITY, 0.0f64), |(low, high), v| (low.min(v), high.max(v)));
        let (low, high) = if low <= high { (low, high) } else { (0.1, 10.0) };
        let room = (high / low).powf(0.06).max(1.3);
        Axis { low: low / room, high: high * room, from, to }
    }

    fn place(&self, value: f64) -> f64 {
        let share = (value.max(self.low) / self.low).ln() / (self.high / self.low).ln();
        self.from + share.min(1.0) * (self.to - self.from)
    }

    /// Values with a tick, and whether they have a label: powers of ten, and 2 and 5 of them where there are few.
    fn ticks(&self) -> Vec<(f64, bool)> {
        let decades = self.low.log10().floor() as i32..=self.high.log10().ceil() as i32;
        let few = (self.high / self.low).log10() < 3.0;
        let all = decades.flat_map(|decade| (1..10).map(move |digit| (digit, f64::from(digit) * 10f64.powi(decade))));
        let inside = all.filter(|(_, value)| (self.low..=self.high).contains(value));
        inside.map(|(digit, value)| (value, digit == 1 || few && (digit == 2 || digit == 5))).collect()
    }
}

/// A number as a label: 0.001 to 10000 written out, others as a power of ten.
fn tick_label(value: f64) -> String {
    let power = value.log10().floor() as i32;
    if (-3..=4).contains(&power) {
        return format!("{:.*}", (-power).max(0) as usize, value);
    }
    let digit = (value / 10f64.powi(power)).round() as i32;
    let raised: String =
        power.to_string().chars().map(|c| if c == '-' { '⁻' } else { RAISED[c as usize - 48] }).collect();
    if digit == 1 { format!("10{raised}") } else { format!("{digit}·10{raised}") }
}

/// A number with one digit left.
fn one_digit(value: f64) -> f64 {
    let power = 10f64.powf(value.log10().floor());
    (value / power).round() * power
}

const RAISED: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];

/// The chart as an `svg` element for a page that defines `--ink`, `--muted`, `--integration` and `--paper`.
pub fn svg(chart: &Chart) -> String {
    format!("{}{}</svg>", head(SIZE[1]), drawn(chart))
}

/// Charts below each other, each under its title, as a file of its own.
pub fn standalone(charts: &[Chart]) -> String {
    let style = "<style>svg{--ink:#1c1e21;--muted:#5c6166;--integration:#e3e4e6;--paper:#fff;background:#fff}</style>";
    let row = SIZE[1] + TITLE;
    let one = |(place, chart): (usize, &Chart)| {
        let (y, title) = (row * place as f64, escape(&chart.title));
        format!(
            "<g transform=\"translate(0 {y})\"><text x=\"{}\" y=\"26\" font-size=\"16\" fill=\"var(--ink)\">{title}</text>\n\
             <g transform=\"translate(0 {TITLE})\">{}</g></g>\n",
            AREA[0],
            drawn(chart)
        )
    };
    let all: String = charts.iter().enumerate().map(one).collect();
    format!("{}{style}\n{all}</svg>", head(row * charts.len().max(1) as f64))
}

/// The start of an `svg` element as high as this.
fn head(height: f64) -> String {
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {height}\" role=\"img\" \
         aria-label=\"Error against time\" font-family=\"system-ui, sans-serif\" font-size=\"13\">\n",
        SIZE[0]
    )
}

/// A chart.
fn drawn(chart: &Chart) -> String {
    let [left, top, right, bottom] = AREA;
    let all = || chart.lines.iter().flat_map(|line| &line.points);
    let x = Axis::over(all().flat_map(|point| point.interval.into_iter().chain([point.time])), left, right);
    // A floor far below would leave the points no room: it is then told at the lower edge.
    let least = all().map(|point| point.error).fold(f64::INFINITY, f64::min);
    let near = chart.floor.filter(|floor| 30.0 * floor >= least);
    let y = Axis::over(all().map(|point| point.error).chain(near), bottom, top);
    let mut out = String::new();
    let mut add = |text: String| {
        out.push_str(&text);
        out.push('\n');
    };
    for (value, label) in x.ticks() {
        let px = x.place(value);
        add(format!(
            "<path d=\"M{px:.1} {top}V{bottom}\" stroke=\"var(--integration)\" stroke-width=\"{}\"/>",
            weight(label)
        ));
        if label {
            let y = bottom + 20.0;
            add(format!(
                "<text x=\"{px:.1}\" y=\"{y}\" text-anchor=\"middle\" fill=\"var(--muted)\">{}</text>",
                tick_label(value)
            ));
        }
    }
    for (value, label) in y.ticks() {
        let py = y.place(value);
        add(format!(
            "<path d=\"M{left} {py:.1}H{right}\" stroke=\"var(--integration)\" stroke-width=\"{}\"/>",
            weight(label)
        ));
        if label {
            let (x, y) = (left - 8.0, py + 4.5);
            add(format!(
                "<text x=\"{x}\" y=\"{y:.1}\" text-anchor=\"end\" fill=\"var(--muted)\">{}</text>",
                tick_label(value)
            ));
        }
    }
    let middle = 0.5 * (left + right);
    add(format!(
        "<text x=\"{middle}\" y=\"{}\" text-anchor=\"middle\" fill=\"var(--ink)\">time {}, ms (median)</text>",
        bottom + 46.0,
        chart.clock
    ));
    let middle = 0.5 * (top + bottom);
    add(format!(
        "<text transform=\"translate(18 {middle}) rotate(-90)\" text-anchor=\"middle\" fill=\"var(--ink)\">RMSE of linear RGBA against the reference</text>"
    ));
    if let Some(floor) = chart.floor.filter(|floor| *floor > 0.0) {
        let (py, right) = (if near.is_some() { y.place(floor) } else { bottom }, right - 6.0);
        let text = format!("error of the reference: {}", tick_label(one_digit(floor)));
        add(format!(
            "<path d=\"M{left} {py:.1}H{}\" stroke=\"var(--muted)\" stroke-width=\"1.5\" stroke-dasharray=\"2 4\"/>",
            right + 6.0
        ));
        add(format!(
            "<text x=\"{right}\" y=\"{:.1}\" text-anchor=\"end\" fill=\"var(--muted)\" font-size=\"12\">{text}{}</text>",
            py - 6.0,
            if near.is_some() { "" } else { ", below" }
        ));
    }
    let place = |&(time, error): &(f64, f64)| (x.place(time), y.place(error));
    if all().next().is_some() {
        SLOPES.into_iter().for_each(|order| add(slope(order, &x, &y)));
    }
    let faint_first = [true, false].into_iter();
    for line in faint_first.flat_map(|faint| chart.lines.iter().filter(move |line| line.faint == faint)) {
        add(self::line(line, &place));
    }
    if let Some(first) = chart.front.first() {
        let (px, py) = place(first);
        let mut path = format!("M{px:.1} {top}V{py:.1}");
        for point in &chart.front[1..] {
            let (px, py) = place(point);
            write!(path, "H{px:.1}V{py:.1}").expect("writing to a string");
        }
        write!(path, "H{right}").expect("writing to a string");
        add(format!(
            "<path d=\"{path}\" fill=\"none\" stroke=\"var(--ink)\" stroke-width=\"1.6\" stroke-opacity=\".75\"/>"
        ));
        for point in &chart.front {
            let (px, py) = place(point);
            add(format!(
                "<circle cx=\"{px:.1}\" cy=\"{py:.1}\" r=\"8\" fill=\"none\" stroke=\"var(--ink)\" stroke-width=\"1.4\"/>"
            ));
        }
    }
    add(legend(chart));
    out
}

/// A line along which the error falls like time^-`order`, from the upper left of the area to its edge.
fn slope(order: i32, x: &Axis, y: &Axis) -> String {
    let time = (x.low * (y.high / y.low).powf(1.0 / f64::from(order))).min(x.high);
    let (px, py) = (x.place(time), y.place(y.high * (time / x.low).powi(-order)));
    let (from_x, from_y) = (x.place(x.low), y.place(y.high));
    // Above the foot of the area, where the error of the reference is named.
    let [label_x, label_y] = [(from_x, px), (from_y, py)].map(|(from, to)| from + 0.85 * (to - from));
    format!(
        "<path d=\"M{from_x:.1} {from_y:.1}L{px:.1} {py:.1}\" stroke=\"var(--muted)\" stroke-dasharray=\"1 5\"/>\
         <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\" fill=\"var(--muted)\" font-size=\"12\">order {order}</text>",
        label_x - 8.0,
        label_y + 4.0
    )
}

fn weight(label: bool) -> f64 {
    if label { 1.0 } else { 0.4 }
}

fn color(group: usize) -> &'static str {
    COLORS[group % COLORS.len()]
}

fn line(line: &Line, place: &impl Fn(&(f64, f64)) -> (f64, f64)) -> String {
    let points: Vec<(f64, f64)> = line.points.iter().map(|point| place(&(point.time, point.error))).collect();
    let path: Vec<String> = points.iter().map(|(px, py)| format!("{px:.1},{py:.1}")).collect();
    let (color, dash) = (color(line.group), if line.filled { "" } else { " stroke-dasharray=\"5 3\"" });
    let opacity = if line.faint { ".35" } else { "1" };
    let mut out = format!("<g opacity=\"{opacity}\" stroke=\"{color}\" stroke-width=\"1.4\">");
    write!(out, "<polyline points=\"{}\" fill=\"none\"{dash}/>", path.join(" ")).expect("writing to a string");
    for (at, point) in points.iter().zip(&line.points) {
        let size = if line.faint { 2.6 } else { 4.0 };
        out += &bars(point, *at, size, place);
        out += &marker(line.marker, line.filled, color, *at, size, &point.about);
    }
    out + "</g>"
}

/// The interval of the time and the doubt about the error, each where it reaches beyond the mark.
fn bars(point: &Point, (px, py): (f64, f64), size: f64, place: &impl Fn(&(f64, f64)) -> (f64, f64)) -> String {
    let [low, high] = point.interval.map(|time| place(&(time, point.error)).0);
    let [down, up] = [-1.0, 1.0].map(|sign| place(&(point.time, point.error + sign * point.reference)).1);
    let mut out = String::new();
    if px - low > size || high - px > size {
        write!(out, "<path d=\"M{low:.1} {py:.1}H{high:.1}m0 -3v6M{low:.1} {:.1}v6\"/>", py - 3.0)
            .expect("writing to a string");
    }
    if down - py > size || py - up > size {
        write!(out, "<path d=\"M{px:.1} {down:.1}V{up:.1}m-3 0h6M{:.1} {down:.1}h6\"/>", px - 3.0)
            .expect("writing to a string");
    }
    out
}

fn marker(kind: Marker, filled: bool, color: &str, (x, y): (f64, f64), size: f64, about: &str) -> String {
    let fill = if filled { color } else { "var(--paper)" };
    let title = if about.is_empty() { String::new() } else { format!("<title>{}</title>", escape(about)) };
    match kind {
        Marker::Circle => format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{size}\" fill=\"{fill}\">{title}</circle>"),
        Marker::Square => {
            let (x, y, side) = (x - size, y - size, 2.0 * size);
            format!("<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{side}\" height=\"{side}\" fill=\"{fill}\">{title}</rect>")
        }
    }
}

/// The names of the groups with their colors, and what the marks mean, to the right of the points.
fn legend(chart: &Chart) -> String {
    let left = AREA[2] + 26.0;
    let mut y = AREA[1] + 10.0;
    let mut out = String::new();
    let mut entry = |mark: String, text: &str| {
        let text = escape(text);
        writeln!(out, "{mark}<text x=\"{}\" y=\"{:.1}\" fill=\"var(--ink)\">{text}</text>", left + 24.0, y + 4.5)
            .expect("writing to a string");
        y += 22.0;
        y
    };
    let mut at = AREA[1] + 10.0;
    for (group, name) in chart.groups.iter().enumerate() {
        let mark = format!("<path d=\"M{} {at}h16\" stroke=\"{}\" stroke-width=\"4\"/>", left - 2.0, color(group));
        at = entry(mark, name);
    }
    let faint = chart.lines.iter().any(|line| line.faint);
    let has = |kind, filled| chart.lines.iter().any(|line| line.marker == kind && line.filled == filled);
    let marks = [
        (Marker::Circle, true, "rays, segments"),
        (Marker::Circle, false, "rays, points"),
        (Marker::Square, true, "slices, segments"),
        (Marker::Square, false, "slices, points"),
    ];
    for (kind, filled, text) in marks.into_iter().filter(|(kind, filled, _)| has(*kind, *filled)) {
        let mark = marker(kind, filled, "var(--muted)", (left + 6.0, at), 4.0, "");
        at = entry(format!("<g stroke=\"var(--muted)\" stroke-width=\"1.4\">{mark}</g>"), text);
    }
    if faint {
        let mark = marker(Marker::Square, false, "var(--muted)", (left + 6.0, at), 2.6, "");
        at = entry(format!("<g stroke=\"var(--muted)\" opacity=\".5\">{mark}</g>"), "other targets and blocks");
    }
    if !chart.front.is_empty() {
        let mark = format!(
            "<circle cx=\"{}\" cy=\"{at}\" r=\"7\" fill=\"none\" stroke=\"var(--ink)\" stroke-width=\"1.4\"/>",
            left + 6.0
        );
        entry(mark, "front: nothing beats it");
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_is_logarithmic_and_its_ends_have_room() {
        let axis = Axis::over([1.0, 100.0, 0.0, f64::INFINITY].into_iter(), 0.0, 100.0);
        assert!((axis.place(10.0) - 50.0).abs() < 1e-9);
        assert!(axis.place(1.0) > 0.0 && axis.place(100.0) < 100.0);
        assert_eq!(axis.place(1e-9), 0.0, "what lies below the axis is drawn on it");
        let labels: Vec<f64> = axis.ticks().into_iter().filter(|tick| tick.1).map(|tick| tick.0).collect();
        assert_eq!(labels, [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0]);
    }

    #[test]
    fn slopes_fall_as_their_order_says_and_stay_in_the_area() {
        // Two decades of time over 200 pixels, four of error over 400: order 2 ends in the corner, order 1 half way down.
        let x = Axis { low: 1.0, high: 100.0, from: 0.0, to: 200.0 };
        let y = Axis { low: 1e-4, high: 1.0, from: 400.0, to: 0.0 };
        for (order, end) in
            [(1, "M0.0 0.0L200.0 200.0\""), (2, "M0.0 0.0L200.0 400.0\""), (4, "M0.0 0.0L100.0 400.0\"")]
        {
            assert!(slope(order, &x, &y).contains(end), "{}", slope(order, &x, &y));
        }
    }

    #[test]
    fn labels_are_written_out_or_powers_of_ten() {
        let written = [1e-6, 2e-5, 0.001, 0.05, 1.0, 20.0, 10000.0, 1e6].map(tick_label);
        assert_eq!(written, ["10⁻⁶", "2·10⁻⁵", "0.001", "0.05", "1", "20", "10000", "10⁶"]);
    }

    #[test]
    fn a_chart_holds_every_point_with_its_words_and_closes_every_tag() {
        let point = |time: f64, error: f64, about: &str| Point {
            time,
            interval: [time; 2],
            error,
            reference: 0.0,
            about: about.into(),
        };
        let line = |filled, faint| Line {
            group: 1,
            marker: Marker::Square,
            filled,
            faint,
            points: vec![point(1.0, 0.1, "a < b"), point(4.0, 0.02, "finer")],
        };
        let chart = Chart {
            title: "x & y".into(),
            groups: vec!["encoded".into(), "procedural".into()],
            lines: vec![line(true, false), line(false, true)],
            front: vec![(1.0, 0.1), (4.0, 0.02)],
            floor: Some(2.2e-6),
            clock: "of the processor",
        };
        let text = svg(&chart);
        assert_eq!(text.matches("<title>a &lt; b</title>").count(), 2);
        for part in [
            "time of the processor, ms",
            ">order 1<",
            ">order 2<",
            "encoded",
            "slices, segments",
            "slices, points",
            "error of the reference: 2·10⁻⁶, below",
            "nothing beats",
        ] {
            assert!(text.contains(part), "{part}");
        }
        assert!(!text.contains("NaN") && !text.contains("rays, points"));
        assert_eq!(text.matches("<g").count(), text.matches("</g>").count());
        assert!(svg(&Chart::default()).ends_with("</svg>"));
        let file = standalone(&[chart.clone(), chart]);
        assert!(file.contains("--paper:#fff") && file.contains("viewBox=\"0 0 960 1192\""), "{file}");
        assert_eq!((file.matches("x &amp; y").count(), file.matches("<svg").count()), (2, 1));
        assert_eq!(file.matches("<g").count(), file.matches("</g>").count());
    }

    #[test]
    fn bars_reach_as_far_as_the_interval_and_the_doubt_and_are_left_out_where_the_mark_hides_them() {
        let place = |&(time, error): &(f64, f64)| (10.0 * time, 100.0 - 1000.0 * error);
        let drawn = |interval, reference| {
            let point = Point { time: 5.0, interval, error: 0.05, reference, about: String::new() };
            bars(&point, place(&(5.0, 0.05)), 4.0, &place)
        };
        assert_eq!(drawn([4.7, 5.3], 0.003), "");
        assert_eq!(drawn([4.0, 5.3], 0.003), "<path d=\"M40.0 50.0H53.0m0 -3v6M40.0 47.0v6\"/>");
        assert_eq!(drawn([4.7, 5.3], 0.01), "<path d=\"M50.0 60.0V40.0m-3 0h6M47.0 60.0h6\"/>");
    }
}
