//! The algorithm and the settings that the command line names.

use super::args::{AlgorithmName, GatheringName, MethodArguments};
use crate::camera::Filter;
use crate::integrate::{ALPHA, Algorithm, EyeSettings, FinalGathering, Settings, VolumeEstimate};
use crate::plan::Wishes;
use clap::ValueEnum;
use clap::builder::PossibleValue;

impl ValueEnum for VolumeEstimate {
    fn value_variants<'a>() -> &'a [Self] {
        &[Self::Beams, Self::BeamRadiance, Self::Points]
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(match self {
            Self::Beams => "beams",
            Self::BeamRadiance => "beam-radiance",
            Self::Points => "points",
        }))
    }
}

impl From<AlgorithmName> for Algorithm {
    fn from(name: AlgorithmName) -> Self {
        match name {
            AlgorithmName::Hybrid => Self::Hybrid,
            AlgorithmName::Path => Self::Path,
            AlgorithmName::Sppm => Self::Sppm,
            AlgorithmName::Ppm => Self::Ppm,
            AlgorithmName::Pm => Self::Pm,
            AlgorithmName::Distributed => Self::Distributed,
            AlgorithmName::Whitted => Self::Whitted,
            AlgorithmName::Raycast => Self::Raycast,
        }
    }
}

pub(super) fn settings(arguments: &MethodArguments, effects: Wishes) -> Settings {
    let photons = arguments.photons.unwrap_or(Settings::default().photons);
    Settings {
        eye: EyeSettings {
            samples: arguments.spp,
            max_bounces: arguments.max_bounces,
            seed: arguments.seed,
            filter: Filter::new(arguments.filter),
            adaptive: arguments.adaptive,
            gauge: false,
            effects,
        },
        photons,
        caustic_photons: arguments.caustic_photons.unwrap_or(photons / 2),
        balance: arguments.photons.is_none() && arguments.caustic_photons.is_none() && arguments.gather_k.is_none(),
        gather_k: arguments.gather_k,
        radius: arguments.radius,
        alpha: arguments.alpha.unwrap_or(ALPHA),
        kernel: arguments.kernel,
        volume: arguments.volume,
        final_gathering: match arguments.final_gathering {
            GatheringName::None => FinalGathering::None,
            GatheringName::Bsdf => FinalGathering::Bsdf,
            GatheringName::Importance => FinalGathering::Importance,
        },
    }
}
