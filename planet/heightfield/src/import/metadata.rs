//! What GDAL notes about the band of a TIFF in tag 42112: scale, offset and unit of its numbers. The tag is XML; only items
//! about the first band are of interest, and they have no elements inside.

use super::geokeys::{FOOT_M, US_FOOT_M};

/// From numbers to metres: `(number * scale + offset) * unit_m`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Band {
    pub(super) scale: f64,
    pub(super) offset: f64,
    /// Metres a unit, if one is named.
    pub(super) unit_m: Option<f64>,
}

impl Band {
    pub(super) const PLAIN: Band = Band { scale: 1.0, offset: 0.0, unit_m: None };

    /// Reads the tag; the words that are not understood, if any.
    pub(super) fn of_metadata(text: &str) -> Result<Band, String> {
        let mut band = Band::PLAIN;
        for item in text.split("<Item ").skip(1) {
            let Some((attributes, rest)) = item.split_once('>') else { continue };
            let value = rest.split('<').next().unwrap_or_default().trim();
            let attribute = |name: &str| attributes.split_once(&format!("{name}=\""))?.1.split('"').next();
            if attribute("sample").is_none_or(|sample| sample != "0") {
                continue;
            }
            let number = || value.parse::<f64>().ok().filter(|n| n.is_finite()).ok_or_else(|| format!("'{value}'"));
            match attribute("role") {
                Some("scale") => band.scale = number().map_err(|v| format!("a scale of {v}"))?,
                Some("offset") => band.offset = number().map_err(|v| format!("an offset of {v}"))?,
                Some("unittype") => band.unit_m = Some(unit_m(value).ok_or_else(|| format!("heights in '{value}'"))?),
                _ => (),
            }
        }
        if band.scale == 0.0 {
            return Err("a scale of 0".into());
        }
        Ok(band)
    }

    /// Metres of a number; of one that is a height as it is, that very number.
    pub(super) fn metres(&self, number: f64) -> f64 {
        match (self.is_plain(), self.unit_m) {
            (true, None | Some(1.0)) => number,
            (_, unit) => (number * self.scale + self.offset) * unit.unwrap_or(1.0),
        }
    }

    /// Whether numbers are heights as they are.
    pub(super) fn is_plain(&self) -> bool {
        self.scale == 1.0 && self.offset == 0.0
    }
}

/// Metres of a unit by its name.
pub(super) fn unit_m(name: &str) -> Option<f64> {
    match name.to_ascii_lowercase().as_str() {
        "" | "m" | "metre" | "metres" | "meter" | "meters" => Some(1.0),
        "ft" | "foot" | "feet" | "international foot" | "international feet" => Some(FOOT_M),
        "us-ft" | "ftus" | "us survey foot" | "us survey feet" | "foot_us" | "feet_us" => Some(US_FOOT_M),
        "cm" | "centimetre" | "centimeter" => Some(0.01),
        "dm" | "decimetre" | "decimeter" => Some(0.1),
        "mm" | "millimetre" | "millimeter" => Some(0.001),
        "km" | "kilometre" | "kilometer" => Some(1000.0),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_of_the_first_band_count() {
        let text = "<GDALMetadata>\n<Item name=\"OFFSET\" sample=\"0\" role=\"offset\">100</Item>\n\
                    <Item name=\"SCALE\" sample=\"0\" role=\"scale\">0.5</Item><Item name=\"SCALE\" sample=\"1\" role=\"scale\">9</Item>\
                    <Item name=\"UNITTYPE\" sample=\"0\" role=\"unittype\">ft</Item><Item name=\"x\">y</Item></GDALMetadata>";
        assert_eq!(Band::of_metadata(text), Ok(Band { scale: 0.5, offset: 100.0, unit_m: Some(0.3048) }));
        assert_eq!(Band::of_metadata("anything"), Ok(Band::PLAIN));
        let item = |role: &str, value: &str| Band::of_metadata(&format!("<Item sample=\"0\" role=\"{role}\">{value}</Item>"));
        assert!(item("scale", "0").is_err() && item("offset", "many").is_err() && item("unittype", "degree Celsius").is_err());
    }
}
