//! Shares of the strata: of b_j, which they give, and of n_j, which they get.

use std::fmt::Write;

use super::{class, scale::significant};

const WIDTH: f64 = 560.0;
const HEIGHT: f64 = 150.0;
const LEFT: f64 = 44.0;
const TOP: f64 = 10.0;
const BOTTOM: f64 = 26.0;

/// A bar a stratum for b_j, with its standard error, and a line across it for n_j; as shares of their sums, in the order
/// of the strata. `None` when all are dark.
///
/// `strata`: b_j, its standard error, n_j.
pub(crate) fn strata(strata: &[(f64, f64, f64)], method: usize) -> Option<String> {
    let sum = |f: fn(&(f64, f64, f64)) -> f64| strata.iter().map(f).sum::<f64>();
    let (b, n) = (sum(|stratum| stratum.0), sum(|stratum| stratum.2));
    if b <= 0.0 || n <= 0.0 {
        return None;
    }
    let largest = strata.iter().map(|stratum| ((stratum.0 + stratum.1) / b).max(stratum.2 / n)).fold(0.0, f64::max);
    let scale = Scale { largest, b, n, step: (WIDTH - LEFT - 8.0) / strata.len() as f64 };
    let mut svg = format!(
        "<svg class=\"chart strata\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"shares of {} strata\">\n{}",
        strata.len(),
        scale.grid()
    );
    svg.extend(strata.iter().enumerate().map(|(j, &stratum)| scale.bar(j, stratum, class(method))));
    let (x, y) = (0.5 * (LEFT + WIDTH), HEIGHT - 8.0);
    let _ = writeln!(
        svg,
        "<text class=\"name\" x=\"{x}\" y=\"{y}\" text-anchor=\"middle\">stratum 0 … {}</text>",
        strata.len() - 1
    );
    Some(svg + "</svg>")
}

/// From strata to points of the chart.
struct Scale {
    /// The largest share.
    largest: f64,
    /// Sum of b_j.
    b: f64,
    /// Sum of n_j.
    n: f64,
    /// Distance between bars.
    step: f64,
}

impl Scale {
    /// Height of a share.
    fn y(&self, share: f64) -> f64 {
        HEIGHT - BOTTOM - share / self.largest * (HEIGHT - BOTTOM - TOP)
    }

    /// Lines at three shares, with their names.
    fn grid(&self) -> String {
        let (mut svg, right, x) = (String::new(), WIDTH - 8.0, LEFT - 6.0);
        for share in [0.0, 0.5 * self.largest, self.largest] {
            let (at, digits) = (self.y(share), if self.largest < 0.1 { 1 } else { 0 });
            let (y, label) = (at + 4.0, format!("{:.digits$} %", 100.0 * share));
            let _ = writeln!(svg, "<line class=\"grid\" x1=\"{LEFT}\" x2=\"{right}\" y1=\"{at:.1}\" y2=\"{at:.1}\"/>");
            let _ = writeln!(svg, "<text class=\"tick\" x=\"{x}\" y=\"{y:.1}\" text-anchor=\"end\">{label}</text>");
        }
        svg
    }

    /// The bar of a stratum.
    fn bar(&self, j: usize, (b_j, stderr, n_j): (f64, f64, f64), class: &str) -> String {
        let (left, width, high) = (LEFT + j as f64 * self.step, 0.8 * self.step, self.y(b_j / self.b));
        let (height, middle) = (self.y(0.0) - high, left + 0.5 * width);
        let (low, up) = (self.y((b_j - stderr) / self.b), self.y((b_j + stderr) / self.b));
        format!(
            "<rect class=\"bar {class}\" x=\"{left:.2}\" y=\"{high:.1}\" width=\"{width:.2}\" height=\"{height:.1}\">\
             <title>stratum {j}: b {} ± {}, n {}</title></rect>\n\
             <path class=\"whisker\" d=\"M{middle:.2} {low:.1}V{up:.1}\"/>\n\
             <path class=\"share\" d=\"M{left:.2} {:.1}h{width:.2}\"/>\n",
            significant(b_j),
            significant(stderr),
            significant(n_j),
            self.y(n_j / self.n)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_stratum_has_a_bar_and_a_share() {
        let svg = strata(&[(1.0, 0.1, 10.0), (0.0, 0.0, 0.0), (3.0, 0.2, 10.0)], 0).expect("not dark");
        for part in ["class=\"bar m0\"", "class=\"whisker\"", "class=\"share\""] {
            assert_eq!(svg.matches(part).count(), 3, "{part}");
        }
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
        assert_eq!(strata(&[(0.0, 0.0, 0.0)], 0), None);
        assert_eq!(strata(&[], 0), None);
    }
}
