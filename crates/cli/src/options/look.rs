//! The options of a look, as arguments: their names, help and checks are those of their declarations.

use std::collections::BTreeMap;
use std::marker::PhantomData;

use clap::error::ErrorKind;
use clap::{Arg, ArgMatches, Args, Command, FromArgMatches};
use gnomon::lights::fit::FitSettings;
use gnomon::options::{Given, OptionError, OptionSpec, OptionValue, Options, specs};
use gnomon::renderer::{DisplaySettings, LightPaths, LightingSettings, TechniqueSettings};
use gnomon::studio::{AnimationLook, EnvironmentLook, Look, PictureSettings, SceneLook};

/// Which options a command takes.
pub trait Selection {
    /// They.
    fn specs() -> Vec<&'static OptionSpec>;
}

/// What is seen and how it is shown, whatever makes the picture.
#[derive(Clone, Debug)]
pub struct Shown;

impl Selection for Shown {
    fn specs() -> Vec<&'static OptionSpec> {
        specs::<(
            EnvironmentLook,
            (SceneLook, (AnimationLook, (PictureSettings, (DisplaySettings, LightPaths)))),
        )>()
    }
}

/// How the GPU draws it.
#[derive(Clone, Debug)]
pub struct Drawn;

impl Selection for Drawn {
    fn specs() -> Vec<&'static OptionSpec> {
        specs::<(FitSettings, (LightingSettings, TechniqueSettings))>()
    }
}

/// How lights are fitted to an environment that no scene is under.
#[derive(Clone, Debug)]
pub struct Fitted;

impl Selection for Fitted {
    fn specs() -> Vec<&'static OptionSpec> {
        specs::<(FitSettings, EnvironmentLook)>()
    }
}

/// Options of a look that were given, of those that a command takes.
#[derive(Clone, Debug)]
pub struct LookArgs<S> {
    /// They. What is not among them is the scene file's, or else the default.
    pub given: Given,
    selection: PhantomData<S>,
}

impl<S: Selection> Args for LookArgs<S> {
    fn augment_args(command: Command) -> Command {
        let mut defaults = BTreeMap::new();
        Look::default().visit(&mut |spec, field| drop(defaults.insert(spec.name(), field.get())));
        let specs = S::specs();
        specs.iter().fold(command, |command, spec| {
            let default = defaults.get(&spec.name()).unwrap_or(&OptionValue::Automatic);
            command.arg(argument(spec, default, &specs))
        })
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<S: Selection> FromArgMatches for LookArgs<S> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut args = Self { given: Given::default(), selection: PhantomData };
        args.update_from_arg_matches(matches)?;
        Ok(args)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        for spec in S::specs() {
            let name = spec.name();
            if let Some(text) = matches.get_one::<String>(&name) {
                self.given.parse(spec, text).map_err(|error| {
                    let error = OptionError { option: format!("--{name}"), ..error };
                    clap::Error::raw(ErrorKind::ValueValidation, format!("{error}\n"))
                })?;
            }
        }
        Ok(())
    }
}

fn argument(spec: &'static OptionSpec, default: &OptionValue, all: &[&'static OptionSpec]) -> Arg {
    let excluded = spec.excludes.and_then(|key| all.iter().find(|other| other.key == key));
    let mut argument = Arg::new(spec.name())
        .long(spec.name())
        .value_name(spec.value_name())
        .help(spec.help_line(default))
        .long_help(spec.long_help(default))
        .help_heading(spec.heading())
        // Parameters of techniques are many: `--help` shows them, `-h` does not.
        .hide_short_help(!spec.group.table.is_empty())
        // Where none is allowed, the option says what is.
        .allow_negative_numbers(true);
    if let Some(alias) = spec.alias.filter(|alias| *alias != spec.name()) {
        argument = argument.visible_alias(alias);
    }
    match excluded {
        Some(other) => argument.conflicts_with(other.name()),
        None => argument,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Args, Debug)]
    struct All {
        #[command(flatten)]
        shown: LookArgs<Shown>,
        #[command(flatten)]
        drawn: LookArgs<Drawn>,
    }

    fn command() -> Command {
        // Lines of any length: words that are looked for are not broken.
        All::augment_args(Command::new("all").term_width(0))
    }

    fn parsed(arguments: &[&str]) -> Result<Look, String> {
        let arguments = std::iter::once("all").chain(arguments.iter().copied());
        let matches = command().try_get_matches_from(arguments).map_err(|error| error.to_string())?;
        let all = All::from_arg_matches(&matches).map_err(|error| error.to_string())?;
        let mut look = Look::default();
        all.shown.given.apply(&mut look);
        all.drawn.given.apply(&mut look);
        Ok(look)
    }

    #[test]
    fn every_option_can_be_given_and_help_tells_the_default_in_force() {
        command().debug_assert();
        let mut look = Look::default();
        let mut defaults = Vec::new();
        look.visit(&mut |spec, field| defaults.push((spec, field.get())));
        let help = command().render_long_help().to_string();
        for (spec, default) in defaults {
            let name = format!("--{}", spec.name());
            assert!(help.contains(&name), "{name}");
            if default != OptionValue::Automatic {
                look = parsed(&[&name, &default.to_string()]).unwrap();
                assert_eq!(look, Look::default(), "{name}");
            }
        }
        assert!(help.contains("[default: 0.25]") && help.contains("pcss: percentage-closer"), "{help}");
        let brief = command().render_help().to_string();
        assert!(brief.contains("--shadows") && !brief.contains("--pcss-search-samples"), "{brief}");
    }

    #[test]
    fn parameters_of_techniques_have_a_name_and_some_a_shorter_one() {
        let look = parsed(&["--pcss-search-samples", "40", "--order", "8", "--exposure", "-2"]).unwrap();
        assert_eq!(look.techniques.shadow_settings.pcss.search_samples, 40);
        assert_eq!(look.techniques.shadow_settings.convolution.order, 8);
        assert_eq!(look.display.exposure, Some(-2.0));
        assert_eq!(
            parsed(&["--convolution-order", "8", "--pcss-search-samples=40", "--exposure=-2"]),
            Ok(look)
        );
    }

    #[test]
    fn a_wrong_value_is_one_line_with_what_is_allowed() {
        let error = parsed(&["--pcss-search-samples", "0"]).unwrap_err();
        assert!(
            error.contains("--pcss-search-samples cannot be `0`: it takes a whole number from 1 to 1024"),
            "{error}"
        );
        assert!(parsed(&["--light-count", "3", "--threshold", "0.1"]).unwrap_err().contains("--threshold"));
    }
}
