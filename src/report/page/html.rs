//! Words and numbers as HTML.

/// The text with what HTML reads as markup written out.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// A number as people read it: four digits that count, a dash where it is not defined.
pub fn number(value: f64) -> String {
    rounded(value, 4)
}

/// A number with so many digits that count; digits before the point all stay.
pub fn rounded(value: f64, digits: i32) -> String {
    if !value.is_finite() {
        return "–".into();
    }
    if value == 0.0 {
        return "0".into();
    }
    let before = value.abs().log10().floor() as i32;
    let text = format!("{value:.*}", (digits - 1 - before).clamp(0, 8) as usize);
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    text.replacen('-', "−", 1)
}

/// A share as percent; near nothing and near all with a tenth.
pub fn percent(part: f64, whole: f64) -> String {
    let share = 100.0 * part / whole;
    match share {
        _ if !share.is_finite() => "–".into(),
        // Neither nothing nor all where it is not.
        _ if (0.0 < share && share < 10.0) || (90.0 < share && share < 100.0) => format!("{share:.1} %"),
        _ => format!("{share:.0} %"),
    }
}

/// `1 root`, `2 roots`.
pub fn count(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_four_digits_that_count() {
        let cases = [
            (912.0473, "912"),
            (0.814_200, "0.8142"),
            (173_568.6, "173569"),
            (0.003_286_75, "0.003287"),
            (-1.0, "−1"),
            (16.0, "16"),
            (1.4, "1.4"),
            (0.0, "0"),
            (f64::NAN, "–"),
            (30.6761, "30.68"),
        ];
        for (value, text) in cases {
            assert_eq!(number(value), text, "{value}");
        }
        assert_eq!(
            (percent(1.0, 3.0), percent(1.0, 200.0), percent(0.0, 0.0)),
            ("33 %".into(), "0.5 %".into(), "–".into())
        );
        assert_eq!([0.032_77, 36.25, 197.6].map(|x| rounded(x, 2)), ["0.033", "36", "198"]);
        assert_eq!(escape("a<b> & \"c\""), "a&lt;b&gt; &amp; &quot;c&quot;");
        assert_eq!((count(1, "root", "roots"), count(0, "root", "roots")), ("1 root".into(), "0 roots".into()));
    }
}
