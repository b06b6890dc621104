//! When a plant was photographed.

use jiff::civil;

/// A date as a list of captures has it.
#[derive(Debug, Clone, PartialEq)]
pub struct Date {
    /// As it is written in results: `2026-05-01`, `2026-05-01T14:30`, `9`.
    pub text: String,
    /// Days since a beginning that is common to the trial.
    pub days: f64,
}

/// Seconds of a day.
const DAY_S: f64 = 86_400.0;

impl Date {
    /// Reads a day, a day with a time, or a number of days.
    ///
    /// # Errors
    /// Says what the text is not.
    pub fn read(text: &str) -> Result<Self, String> {
        let text = text.trim();
        if let Some(days) = text.parse::<f64>().ok().filter(|d| d.is_finite() && d.abs() < 1e6) {
            return Ok(Self { text: text.to_owned(), days });
        }
        if let Ok(date) = text.parse::<civil::Date>()
            && text.len() <= 10
        {
            return Ok(Self { text: date.to_string(), days: days(date.at(0, 0, 0, 0)) });
        }
        let time = text.parse::<civil::DateTime>().map_err(|_| format!("`{text}` is no date"))?;
        let text = time.strftime(if time.second() == 0 { "%Y-%m-%dT%H:%M" } else { "%Y-%m-%dT%H:%M:%S" }).to_string();
        Ok(Self { text, days: days(time) })
    }

    /// Reads a text by a pattern such as `%Y-%m-%d`; without a pattern as [`Self::read`].
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn read_as(text: &str, pattern: Option<&str>) -> Result<Self, String> {
        let Some(pattern) = pattern else { return Self::read(text) };
        let other = |_| format!("`{text}` is no date like {pattern}");
        let parts = jiff::fmt::strtime::BrokenDownTime::parse(pattern, text).map_err(other)?;
        match parts.hour() {
            Some(_) => Self::read(&parts.to_datetime().map_err(other)?.to_string()),
            None => Self::read(&parts.to_date().map_err(other)?.to_string()),
        }
    }
}

fn days(time: civil::DateTime) -> f64 {
    time.duration_since(civil::date(2000, 1, 1).at(0, 0, 0, 0)).as_secs_f64() / DAY_S
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_times_and_numbers_of_days_are_dates() {
        let days = |text: &str| Date::read(text).unwrap().days;
        assert_eq!(days("2026-05-03") - days("2026-05-01"), 2.0);
        assert_eq!(days("2026-05-03T12:00") - days("2026-05-03"), 0.5);
        assert_eq!(days("9") - days("7.5"), 1.5);
        assert_eq!(Date::read("2026-05-03T12:00:00").unwrap().text, "2026-05-03T12:00");
        assert!(Date::read("May").is_err() && Date::read("2026-13-01").is_err() && Date::read("").is_err());
        assert_eq!(Date::read_as("03.05.2026", Some("%d.%m.%Y")).unwrap().text, "2026-05-03");
        assert!(Date::read_as("2026-05-03", Some("%d.%m.%Y")).is_err());
    }
}
