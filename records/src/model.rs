//! Model files: an identified chamber and its origin. Written so that reading restores every bit.
//!
//! Only `[chamber] bore_m` and `[heat_transfer] coefficient_w_per_m2_k` are required. Defaults are: air, no rod, no dead volume,
//! area law `"total"`, the paper's reference state (5.65e5 Pa, 293 K), no effect, surroundings at 293.15 K and 101325 Pa; for a
//! named effect, its parameters' neutral values.

use crate::ambient;
use crate::atomic::write_atomically;
use crate::document::{Document, Kind};
use crate::effect;
use crate::error::Error;
use crate::gas::{self, NamedGas};
use crate::limits;
use crate::provenance::Provenance;
use crate::table::Table;
use crate::toml_text::{number, quoted};
use crate::uncertainty::Uncertainty;
use chamber::effects::{self, EffectSet};
use chamber::{AreaLaw, Chamber, EffectValues, Geometry, HeatTransfer, paper};
use std::fmt::Write;
use std::path::Path;

/// A chamber as stored in a model file.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// Name of the gas: one of [`chamber::Gas::NAMED`], or a user's label.
    pub gas_name: Option<String>,
    /// All its constants, effects included.
    pub chamber: Chamber,
    /// Temperature of the surroundings, K.
    pub ambient_temperature_k: f64,
    /// Pressure of the surroundings, Pa.
    pub ambient_pressure_pa: f64,
    /// Uncertainty of the parameters; absent in a model written by hand.
    pub uncertainty: Option<Uncertainty>,
    /// Origin of the numbers.
    pub provenance: Provenance,
}

const AREA_LAWS: [(&str, AreaLaw); 2] = [("total", AreaLaw::Total), ("swept", AreaLaw::Swept)];

impl Model {
    /// Reads a model file.
    ///
    /// # Errors
    /// [`Error`] names the file, the line and the key.
    pub fn read(path: &Path) -> Result<Self, Error> {
        Self::from_document(&Document::read_as(Kind::Model, path)?)
    }

    /// Reads a model from a document.
    ///
    /// # Errors
    /// As [`Model::read`].
    pub fn from_document(document: &Document) -> Result<Self, Error> {
        let root = document.root();
        root.allow(&["gas", "chamber", "heat_transfer", "effect", "ambient", "uncertainty", "provenance"])?;
        let NamedGas { name: gas_name, gas } = gas::read(&root)?;
        let geometry = read_geometry(&root.required_table("chamber")?)?;
        let heat_transfer = read_heat_transfer(&root.required_table("heat_transfer")?)?;
        let effects = root.table("effect")?.map_or(Ok(EffectValues::NEUTRAL), |table| read_effects(&table))?;
        let (temperature_k, pressure_pa) = ambient::read(&root)?;
        Ok(Self {
            gas_name,
            chamber: Chamber { gas, geometry, heat_transfer, effects },
            ambient_temperature_k: temperature_k.unwrap_or(limits::ROOM_TEMPERATURE_K),
            ambient_pressure_pa: pressure_pa.unwrap_or(limits::STANDARD_ATMOSPHERE_PA),
            uncertainty: Uncertainty::read(&root)?,
            provenance: Provenance::read(&root)?,
        })
    }

    /// Writes the model file, atomically.
    ///
    /// # Errors
    /// [`Error::Write`], or [`Error::Unwritable`] as for [`Model::to_toml`].
    pub fn write(&self, path: &Path) -> Result<(), Error> {
        write_atomically(path, self.to_toml()?.as_bytes())
    }

    /// The model file's text.
    ///
    /// # Errors
    /// [`Error::Unwritable`] for a model that would not be read back the same: a number not finite or out of bounds, or a piston
    /// area that does not match bore and rod.
    pub fn to_toml(&self) -> Result<String, Error> {
        let mut text = String::new();
        self.render(&mut text).map_err(|_| Error::Unwritable("formatting failed".to_owned()))?;
        let read_back = Document::parse(Path::new("model"), text.clone()).and_then(|d| Self::from_document(&d));
        let mut same = read_back.map_err(|error| Error::Unwritable(error.to_string()))?;
        let (ours, theirs) = (self.chamber.geometry.piston_area, same.chamber.geometry.piston_area);
        if (ours / theirs - 1.0).abs() > 1e-12 {
            let message = format!("its piston area {ours:?} m2 is not that of bore and rod, {theirs:?} m2");
            return Err(Error::Unwritable(message));
        }
        same.chamber.geometry.piston_area = ours;
        if same != *self {
            return Err(Error::Unwritable("it would not read back the same".to_owned()));
        }
        Ok(text)
    }

    fn render(&self, out: &mut String) -> std::fmt::Result {
        let Chamber { gas, geometry, heat_transfer, effects } = &self.chamber;
        writeln!(out, "# A pneumatic cylinder chamber for pneutherm. SI units, absolute pressure.\n\n[gas]")?;
        if let Some(name) = &self.gas_name {
            writeln!(out, "name = {}", quoted(name))?;
        }
        writeln!(out, "gas_constant_j_per_kg_k = {}", number(gas.gas_constant))?;
        writeln!(out, "heat_capacity_ratio = {}", number(gas.heat_capacity_ratio))?;
        writeln!(out, "\n[chamber]\nbore_m = {}", number(geometry.bore))?;
        writeln!(out, "rod_m = {}  # of a rod that runs through this chamber", number(geometry.rod_diameter))?;
        writeln!(out, "dead_volume_m3 = {}", number(geometry.dead_volume))?;
        writeln!(out, "area_law = \"{}\"", geometry.area_law.name())?;
        writeln!(out, "\n[heat_transfer]\ncoefficient_w_per_m2_k = {}", number(heat_transfer.coefficient))?;
        writeln!(out, "reference_pressure_pa = {}", number(heat_transfer.reference_pressure))?;
        writeln!(out, "reference_temperature_k = {}", number(heat_transfer.reference_temperature))?;
        for (index, card) in effects::all().filter(|(index, _)| effects.active().has(*index)) {
            writeln!(out, "\n[effect.{}]  # {}", card.name, card.doc)?;
            effect::write(out, card, effects.of(index))?;
        }
        writeln!(out, "\n[ambient]\ntemperature_k = {}", number(self.ambient_temperature_k))?;
        writeln!(out, "pressure_pa = {}", number(self.ambient_pressure_pa))?;
        if let Some(uncertainty) = &self.uncertainty {
            writeln!(out)?;
            uncertainty.write(out)?;
        }
        if !self.provenance.is_empty() {
            writeln!(out)?;
            self.provenance.write(out)?;
        }
        Ok(())
    }

    /// Turns off the effects that act on the stroke record, for uses in which the stroke is the true one; returns those that were
    /// on.
    pub fn exclude_recorded_stroke_effects(&mut self) -> EffectSet {
        let excluded = self.active().intersection(effects::of_recorded_stroke());
        self.chamber.effects = self.chamber.effects.without(excluded);
        excluded
    }

    /// The effects that are on.
    pub fn active(&self) -> EffectSet {
        self.chamber.active()
    }
}

fn read_geometry(table: &Table<'_>) -> Result<Geometry, Error> {
    table.allow(&["bore_m", "rod_m", "dead_volume_m3", "area_law"])?;
    let bore = table.required_number("bore_m", &limits::BORE_M)?;
    let rod = table.number("rod_m", &limits::ROD_M)?.unwrap_or(0.0);
    limits::check_rod(table, bore, rod)?;
    let dead_volume = table.number("dead_volume_m3", &limits::DEAD_VOLUME_M3)?.unwrap_or(0.0);
    let area_law = table.choice("area_law", &AREA_LAWS)?.unwrap_or(AreaLaw::Total);
    Ok(Geometry::new(bore, rod, dead_volume, area_law))
}

fn read_heat_transfer(table: &Table<'_>) -> Result<HeatTransfer, Error> {
    table.allow(&["coefficient_w_per_m2_k", "reference_pressure_pa", "reference_temperature_k"])?;
    Ok(HeatTransfer {
        coefficient: table.required_number("coefficient_w_per_m2_k", &limits::COEFFICIENT)?,
        reference_pressure: table
            .number("reference_pressure_pa", &limits::PRESSURE_PA)?
            .unwrap_or(paper::REFERENCE_PRESSURE_PA),
        reference_temperature: table
            .number("reference_temperature_k", &limits::TEMPERATURE_K)?
            .unwrap_or(paper::REFERENCE_TEMPERATURE_K),
    })
}

fn read_effects(table: &Table<'_>) -> Result<EffectValues, Error> {
    table.allow(&effects::all().map(|(_, card)| card.name).collect::<Vec<_>>())?;
    let mut values = EffectValues::NEUTRAL;
    for (index, card) in effects::all() {
        if let Some(effect) = table.table(card.name)? {
            effect::read(&effect, card, values.of_mut(index))?;
        }
    }
    Ok(values)
}
