//! Tables as a file: JSON.

use glam::Vec3;
use gnomon_brdf::Tables;
use gnomon_brdf::tables::{Coordinates, Factor, Table, Term, Tint};
use serde::{Deserialize, Serialize};

use crate::error::{MeasuredError, invalid};

/// Of the format.
const VERSION: u32 = 1;
/// Largest side of a table, most factors, and largest value.
const MAX_SIDE: usize = 1024;
const MAX_FACTORS: usize = 64;
const MAX_VALUE: f32 = 1e9;

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct Document {
    gnomon_tables: u32,
    #[serde(default)]
    turn: f32,
    terms: Vec<TermEntry>,
}

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct TermEntry {
    tint: TintEntry,
    factors: Vec<FactorEntry>,
}

#[derive(Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
enum TintEntry {
    Color,
    Grazing,
}

#[derive(Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
enum CoordinatesEntry {
    Half,
    HalfQuadrant(f32),
    HalfAndDifference,
    Cosines,
    Difference,
    Light,
    View,
    Tangent,
    CosineLobe([f32; 3]),
}

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct FactorEntry {
    coordinates: CoordinatesEntry,
    scale: f32,
    columns: usize,
    /// Row by row, red, green, blue.
    values: Vec<f32>,
}

/// A file of tables.
///
/// # Errors
/// [`MeasuredError::Invalid`] with the line of what is wrong.
pub fn parse(bytes: &[u8]) -> Result<Tables, MeasuredError> {
    let document: Document = serde_json::from_slice(bytes).map_err(|error| invalid(error.to_string()))?;
    if document.gnomon_tables != VERSION {
        return Err(invalid(format!(
            "tables of version {VERSION} are read, these are of {}",
            document.gnomon_tables
        )));
    }
    let factors: usize = document.terms.iter().map(|term| term.factors.len()).sum();
    if factors == 0 || factors > MAX_FACTORS || document.terms.iter().any(|term| term.factors.is_empty()) {
        return Err(invalid(format!("a file holds 1 to {MAX_FACTORS} tables, and every term one at least")));
    }
    if !document.turn.is_finite() {
        return Err(invalid("turn must be finite"));
    }
    let terms = document.terms.into_iter().map(|term| {
        let tint = match term.tint {
            TintEntry::Color => Tint::Color,
            TintEntry::Grazing => Tint::Grazing,
        };
        let factors = term.factors.into_iter().map(factor).collect::<Result<_, _>>()?;
        Ok(Term { tint, factors })
    });
    let tables = Tables::new(terms.collect::<Result<_, MeasuredError>>()?, document.turn);
    match tables.most().is_finite() {
        true => Ok(tables),
        false => Err(invalid("products of the tables are no finite numbers")),
    }
}

fn factor(entry: FactorEntry) -> Result<Factor, MeasuredError> {
    let coordinates = match entry.coordinates {
        CoordinatesEntry::Half => Coordinates::Half,
        CoordinatesEntry::HalfQuadrant(stretch) => Coordinates::HalfQuadrant(stretch),
        CoordinatesEntry::HalfAndDifference => Coordinates::HalfAndDifference,
        CoordinatesEntry::Cosines => Coordinates::Cosines,
        CoordinatesEntry::Difference => Coordinates::Difference,
        CoordinatesEntry::Light => Coordinates::Light,
        CoordinatesEntry::View => Coordinates::View,
        CoordinatesEntry::Tangent => Coordinates::Tangent,
        CoordinatesEntry::CosineLobe(axes) => Coordinates::CosineLobe(Vec3::from_array(axes)),
    };
    let parameters = coordinates.parameters();
    let numbers = entry.values.iter().chain(parameters.as_ref());
    if !numbers.chain([&entry.scale]).all(|value| value.abs() <= MAX_VALUE) || entry.scale < 0.0 {
        return Err(invalid(format!("values of tables must lie within {MAX_VALUE:e}, scales at 0 or above")));
    }
    let (columns, values) = (entry.columns, entry.values);
    let is_table = (1..=MAX_SIDE).contains(&columns)
        && values.len().is_multiple_of(3 * columns)
        && values.len() / columns / 3 <= MAX_SIDE;
    let texels = values.chunks_exact(3).map(|v| Vec3::new(v[0], v[1], v[2])).collect();
    let table = is_table.then(|| Table::of_rows(columns, texels)).flatten();
    let table = table.ok_or_else(|| {
        invalid(format!("a table has 1 to {MAX_SIDE} columns and rows of three values each"))
    })?;
    Ok(Factor { coordinates, scale: entry.scale, table })
}

/// Tables as such a file.
pub fn to_text(tables: &Tables) -> String {
    let factor = |factor: &Factor| FactorEntry {
        coordinates: match factor.coordinates {
            Coordinates::Half => CoordinatesEntry::Half,
            Coordinates::HalfQuadrant(stretch) => CoordinatesEntry::HalfQuadrant(stretch),
            Coordinates::HalfAndDifference => CoordinatesEntry::HalfAndDifference,
            Coordinates::Cosines => CoordinatesEntry::Cosines,
            Coordinates::Difference => CoordinatesEntry::Difference,
            Coordinates::Light => CoordinatesEntry::Light,
            Coordinates::View => CoordinatesEntry::View,
            Coordinates::Tangent => CoordinatesEntry::Tangent,
            Coordinates::CosineLobe(axes) => CoordinatesEntry::CosineLobe(axes.to_array()),
        },
        scale: factor.scale,
        columns: factor.table.columns(),
        values: factor.table.values().iter().flat_map(|value| value.to_array()).collect(),
    };
    let term = |term: &Term| TermEntry {
        tint: match term.tint {
            Tint::Color => TintEntry::Color,
            Tint::Grazing => TintEntry::Grazing,
        },
        factors: term.factors.iter().map(factor).collect(),
    };
    let document = Document {
        gnomon_tables: VERSION,
        turn: tables.turn(),
        terms: tables.terms().iter().map(term).collect(),
    };
    // Numbers and lists cannot fail to be written.
    serde_json::to_string(&document).unwrap_or_default()
}
