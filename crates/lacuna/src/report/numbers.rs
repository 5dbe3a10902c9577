//! Numbers as people read them.

/// A whole number with its thousands apart: `1 234 567`.
pub(crate) fn grouped(value: u64) -> String {
    let digits = value.to_string();
    let mut text = String::with_capacity(digits.len() * 4 / 3);
    for (k, digit) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

/// An area in square metres: whole ones from 100 on, else one decimal below.
pub(crate) fn area(area_m2: f64) -> String {
    if !area_m2.is_finite() {
        return "?".to_owned();
    }
    if area_m2.abs() < 99.95 { format!("{area_m2:.1}") } else { grouped(area_m2.round() as u64) }
}

/// Bytes in the largest binary unit that leaves at least 1: `1.4 GiB`.
pub(crate) fn bytes(count: u64) -> String {
    const UNITS: [&str; 6] = ["B", "KiB", "MiB", "GiB", "TiB", "PiB"];
    let mut value = count as f64;
    let mut unit = 0;
    while value >= 1023.95 && unit + 1 < UNITS.len() {
        value /= 1024.0;
        unit += 1;
    }
    if unit == 0 { format!("{count} B") } else { format!("{value:.1} {}", UNITS[unit]) }
}

/// A time: `0.4 s`, `12 s`, `1:02 min`, `1:02:03 h`.
pub(crate) fn seconds(time: f64) -> String {
    if time < 9.95 {
        return format!("{:.1} s", time.max(0.0));
    }
    let whole = time.round() as u64;
    match (whole / 3600, whole / 60 % 60, whole % 60) {
        (0, 0, s) => format!("{s} s"),
        (0, m, s) => format!("{m}:{s:02} min"),
        (h, m, s) => format!("{h}:{m:02}:{s:02} h"),
    }
}

/// `1 hole`, `2 holes`.
pub(crate) fn count(number: u64, one: &str, many: &str) -> String {
    format!("{} {}", grouped(number), if number == 1 { one } else { many })
}

#[cfg(test)]
mod tests {
    use super::{area, bytes, grouped, seconds};

    #[test]
    fn reads_well() {
        for (value, text) in [(0, "0"), (999, "999"), (1000, "1 000"), (1_234_567, "1 234 567")] {
            assert_eq!(grouped(value), text);
        }
        for (value, text) in
            [(0.0, "0.0"), (99.94, "99.9"), (99.97, "100"), (4498.2, "4 498"), (f64::NAN, "?")]
        {
            assert_eq!(area(value), text);
        }
        for (value, text) in
            [(12, "12 B"), (1024, "1.0 KiB"), (1 << 30, "1.0 GiB"), ((1 << 20) - 1, "1.0 MiB")]
        {
            assert_eq!(bytes(value), text);
        }
        for (value, text) in [(0.42, "0.4 s"), (12.3, "12 s"), (62.0, "1:02 min"), (3723.0, "1:02:03 h")] {
            assert_eq!(seconds(value), text);
        }
    }
}
