//! Catalogues of stars: a text of values between commas whose first line names the columns.

use super::{Star, irradiance_of};
use bhs_elementary::Elementary;
use glam::DVec3;

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Column {
    X,
    Y,
    Z,
    RightAscension,
    Declination,
    Magnitude,
    Flux,
    Temperature,
    ColourIndex,
}

impl Column {
    /// The one of that name.
    fn of(name: &str) -> Option<Self> {
        Some(match name.trim().to_ascii_lowercase().as_str() {
            "x" => Self::X,
            "y" => Self::Y,
            "z" => Self::Z,
            "ra" => Self::RightAscension,
            "dec" => Self::Declination,
            "mag" | "magnitude" | "vmag" => Self::Magnitude,
            "flux" => Self::Flux,
            "temperature" | "teff" => Self::Temperature,
            "ci" | "b-v" | "bv" => Self::ColourIndex,
            _ => return None,
        })
    }
}

/// The columns of a file that are used, with their names and places.
struct Columns<'a>(Vec<(Column, &'a str, usize)>);

/// Colour indices B-V for which Ballesteros' formula holds, and some more.
const COLOUR_INDICES: std::ops::RangeInclusive<f64> = -0.5..=6.0;
/// Magnitudes that are plausible: the sun is -26.7.
const MAGNITUDES: std::ops::RangeInclusive<f64> = -30.0..=40.0;
/// Temperatures (K).
const TEMPERATURES: std::ops::RangeInclusive<f64> = 100.0..=1e6;

/// The stars of a file, or what is wrong with its lines.
pub fn parse(bytes: &[u8]) -> Result<Vec<Star>, Vec<String>> {
    let fault = |text: &str| Err(vec![text.to_owned()]);
    match bytes {
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => return fault("it is not text in UTF-8 or ASCII, but in UTF-16"),
        _ if bytes.contains(&0) => return fault("it is not text"),
        _ => {}
    }
    let text = String::from_utf8_lossy(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes));
    let lines = text.lines().enumerate().map(|(i, line)| (i + 1, line.split('#').next().unwrap_or_default()));
    let mut lines = lines.filter(|(_, line)| !line.trim().is_empty());
    let Some((number, header)) = lines.next() else { return fault("it is empty") };
    let columns = Columns::new(&fields(header)).map_err(|fault| vec![format!("line {number}: {fault}")])?;
    let (mut stars, mut faults) = (Vec::new(), Vec::new());
    for (number, line) in lines {
        match columns.star(&fields(line)) {
            Ok(star) => stars.push(star),
            Err(fault) => faults.push(format!("line {number}: {fault}")),
        }
    }
    if stars.is_empty() && faults.is_empty() {
        return fault("it has no stars");
    }
    if faults.is_empty() { Ok(stars) } else { Err(faults) }
}

/// The fields of a line. A field in double quotes may have commas in it.
fn fields(line: &str) -> Vec<&str> {
    let mut in_quotes = false;
    let parts = line.split(move |c| {
        in_quotes ^= c == '"';
        c == ',' && !in_quotes
    });
    parts.map(|field| field.trim().trim_matches('"').trim()).collect()
}

impl<'a> Columns<'a> {
    /// Those that a header names.
    fn new(header: &[&'a str]) -> Result<Self, String> {
        if header.iter().any(|name| name.parse::<f64>().is_ok()) {
            return Err("expected the names of the columns, found numbers".to_owned());
        }
        let columns: Vec<_> = header.iter().enumerate().filter_map(|(i, name)| Some((Column::of(name)?, *name, i))).collect();
        for (i, (column, name, _)) in columns.iter().enumerate() {
            if let Some((_, first, _)) = columns[..i].iter().find(|(other, ..)| other == column) {
                return Err(format!("the columns `{first}` and `{name}` say the same"));
            }
        }
        let columns = Self(columns);
        if !columns.has(&[Column::X, Column::Y, Column::Z]) && !columns.has(&[Column::RightAscension, Column::Declination]) {
            return Err("no column says where a star is: it takes `x`, `y`, `z`, or `ra` and `dec` (degrees)".to_owned());
        }
        if !columns.has(&[Column::Magnitude]) && !columns.has(&[Column::Flux]) {
            return Err("no column says how bright a star is: it takes `mag`, or `flux` (W m^-2 nm^-1)".to_owned());
        }
        Ok(columns)
    }

    fn has(&self, wanted: &[Column]) -> bool {
        wanted.iter().all(|wanted| self.0.iter().any(|(column, ..)| column == wanted))
    }

    /// The number of a line in a column; `None` where there is no such column, or nothing in it.
    fn number(&self, fields: &[&str], wanted: Column) -> Result<Option<f64>, String> {
        let Some((_, name, i)) = self.0.iter().find(|(column, ..)| *column == wanted) else { return Ok(None) };
        let Some(field) = fields.get(*i) else {
            return Err(format!("column `{name}`: the line ends before it"));
        };
        match field.parse::<f64>() {
            _ if field.is_empty() => Ok(None),
            Ok(x) if x.is_finite() => Ok(Some(x)),
            Ok(_) => Err(format!("column `{name}`: `{field}` is not finite")),
            Err(_) => Err(format!("column `{name}`: `{field}` is not a number")),
        }
    }

    /// A number that must be there.
    fn required(&self, fields: &[&str], wanted: Column) -> Result<f64, String> {
        let name = self.0.iter().find(|(column, ..)| *column == wanted).map_or("", |(_, name, _)| name);
        self.number(fields, wanted)?.ok_or_else(|| format!("column `{name}`: it is empty"))
    }

    /// A number that must lie within `range`.
    fn within(&self, fields: &[&str], wanted: Column, range: &std::ops::RangeInclusive<f64>) -> Result<Option<f64>, String> {
        let name = self.0.iter().find(|(column, ..)| *column == wanted).map_or("", |(_, name, _)| name);
        match self.number(fields, wanted)? {
            Some(x) if !range.contains(&x) => {
                Err(format!("column `{name}`: expected {} to {}, found {x}", range.start(), range.end()))
            }
            other => Ok(other),
        }
    }

    fn direction(&self, fields: &[&str]) -> Result<DVec3, String> {
        if self.has(&[Column::X, Column::Y, Column::Z]) {
            let [x, y, z] = [Column::X, Column::Y, Column::Z].map(|column| self.required(fields, column));
            let direction = DVec3::new(x?, y?, z?);
            // Not the length of tiny or huge vectors, whose squares are no numbers.
            let largest = direction.abs().max_element();
            return match largest > 0.0 {
                true => Ok((direction / largest).normalize()),
                false => Err("`x`, `y` and `z` are zero: no direction".to_owned()),
            };
        }
        let ra = self.required(fields, Column::RightAscension)?;
        let dec = self.required(fields, Column::Declination)?;
        if !(-360.0..=360.0).contains(&ra) {
            return Err(format!("a right ascension lies between 0 and 360 degrees, found {ra}"));
        }
        if !(-90.0..=90.0).contains(&dec) {
            return Err(format!("a declination lies between -90 and 90 degrees, found {dec}"));
        }
        let ((sin, cos), (z, across)) = (ra.to_radians().sine_cosine(), dec.to_radians().sine_cosine());
        // Right ascensions grow to the left where north is up, and the axes of scenes are left-handed.
        Ok(DVec3::new(across * cos, -across * sin, z))
    }

    fn star(&self, fields: &[&str]) -> Result<Star, String> {
        let direction = self.direction(fields)?;
        let irradiance = match self.number(fields, Column::Flux)? {
            Some(flux) if flux < 0.0 => return Err(format!("a flux is not negative, found {flux}")),
            Some(flux) => flux,
            None => match self.within(fields, Column::Magnitude, &MAGNITUDES)? {
                Some(magnitude) => irradiance_of(magnitude),
                None => return Err("it has no magnitude and no flux".to_owned()),
            },
        };
        let temperature = match self.within(fields, Column::Temperature, &TEMPERATURES)? {
            Some(temperature) => Some(temperature),
            None => self.within(fields, Column::ColourIndex, &COLOUR_INDICES)?.map(temperature_of),
        };
        Ok(Star { direction, irradiance, temperature })
    }
}

/// The temperature (K) of a black body of the colour index B-V (Ballesteros 2012).
fn temperature_of(colour_index: f64) -> f64 {
    4600.0 * (1.0 / (0.92 * colour_index + 1.7) + 1.0 / (0.92 * colour_index + 0.62))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn faults(text: &str) -> String {
        parse(text.as_bytes()).expect_err("it is faulty").join("; ")
    }

    #[test]
    fn directions_magnitudes_and_colours_are_read() {
        let text = "# bright ones\r\nname,RA,Dec,Vmag,B-V\r\n\"Vega, alpha Lyr\",279.2347,38.7837,0.03,0.00\r\nx,90,-30,5,\r\n";
        let [vega, other] = parse(text.as_bytes()).expect("it is right")[..] else { panic!("two stars") };
        // 18h 36m 56s, +38 deg 47': the direction cosines of almanacs (Vega, J2000), y turned around.
        assert!((vega.direction - DVec3::new(0.125_1, 0.769_4, 0.626_4)).length() < 2e-4, "{}", vega.direction);
        assert!((vega.irradiance / 3.631e-11 - 0.972_75).abs() < 1e-4);
        // Ballesteros 2012: 4600 (1/1.7 + 1/0.62) K.
        assert!((vega.temperature.expect("it has a colour") - 10_125.2).abs() < 0.1);
        assert!((other.direction - DVec3::new(0.0, -0.75f64.sqrt(), -0.5)).length() < 1e-12 && other.temperature.is_none());
        // The sun's B-V of 0.65 is 5770 K or so.
        assert!((temperature_of(0.65) - 5780.0).abs() < 80.0, "{}", temperature_of(0.65));
        let [star] = parse(b"x,y,z,flux,temperature\n0,0,-2e200,1e-9,4000\n").expect("it is right")[..] else { panic!() };
        assert_eq!(star, Star { direction: -DVec3::Z, irradiance: 1e-9, temperature: Some(4000.0) });
    }

    #[test]
    fn faults_have_line_and_column() {
        for (text, expected) in [
            ("", "it is empty"),
            ("ra,dec,mag\n", "it has no stars"),
            ("1,2,3\n", "line 1: expected the names of the columns"),
            ("ra,mag\n1,2\n", "line 1: no column says where a star is"),
            ("ra,dec,colour\n", "line 1: no column says how bright"),
            ("ra,dec,mag,vmag\n", "the columns `mag` and `vmag` say the same"),
            ("ra,dec,mag\n1,2,3\n1,2,x\n", "line 3: column `mag`: `x` is not a number"),
            ("ra,dec,mag\n1,2\n", "line 2: column `mag`: the line ends before it"),
            ("ra,dec,mag\n1,,3\n", "line 2: column `dec`: it is empty"),
            ("ra,dec,mag\n1,2,inf\n", "column `mag`: `inf` is not finite"),
            ("ra,dec,mag\n1,91,3\n", "a declination lies between -90 and 90 degrees, found 91"),
            ("ra,dec,mag\n1,2,99\n", "column `mag`: expected -30 to 40, found 99"),
            ("ra,dec,mag,ci\n1,2,3,-0.6\n", "column `ci`: expected -0.5 to 6, found -0.6"),
            ("x,y,z,mag\n0,0,0,3\n", "`x`, `y` and `z` are zero"),
            ("ra,dec,flux\n1,2,-3\n", "a flux is not negative"),
            ("ra,dec,mag\n1,2,\n", "it has no magnitude and no flux"),
        ] {
            assert!(faults(text).contains(expected), "{text:?}: {}", faults(text));
        }
        assert!(faults("\0").contains("not text"));
    }
}
