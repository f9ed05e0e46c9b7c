use crate::report::Section;
use crate::{Lab, LabError};

/// One figure or table of a paper, or one requirement, measured.
pub trait Experiment: Sync {
    /// Name on the command line and in JSON.
    fn name(&self) -> &'static str;

    /// What it measures and what it reproduces; the heading of its section.
    fn title(&self) -> &'static str;

    /// Measures. Name and title of the section are the caller's to fill in.
    ///
    /// # Errors
    /// [`LabError`]: the adapter, the data or the request.
    fn run(&self, lab: &Lab<'_>) -> Result<Section, LabError>;
}

/// The evaluation of one paper, or of one property of the renderer.
pub struct Suite {
    /// Name on the command line.
    pub name: &'static str,
    /// What it evaluates; the heading of its report.
    pub title: &'static str,
    /// Its experiments, in the order in which they run.
    pub experiments: &'static [&'static dyn Experiment],
}

impl Suite {
    /// The experiments called `names`, in the suite's order; all of them for none.
    ///
    /// # Errors
    /// [`LabError::Request`] lists the names there are.
    pub fn choose(&self, names: &[String]) -> Result<Vec<&'static dyn Experiment>, LabError> {
        let known = |name: &str| self.experiments.iter().any(|experiment| experiment.name() == name);
        if let Some(unknown) = names.iter().find(|name| !known(name)) {
            let all: Vec<_> = self.experiments.iter().map(|experiment| experiment.name()).collect();
            return Err(LabError::Request(format!(
                "there is no experiment '{unknown}' (there are: {})",
                all.join(", ")
            )));
        }
        let chosen = |name: &str| names.is_empty() || names.iter().any(|chosen| chosen == name);
        Ok(self.experiments.iter().copied().filter(|experiment| chosen(experiment.name())).collect())
    }

    /// Runs one experiment; its section bears its name and title.
    ///
    /// # Errors
    /// As [`Experiment::run`].
    pub fn run(experiment: &dyn Experiment, lab: &Lab<'_>) -> Result<Section, LabError> {
        let section = experiment.run(lab)?;
        Ok(Section { name: experiment.name().to_owned(), title: experiment.title().to_owned(), ..section })
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn names_are_unique_and_chosen_in_order() {
        for suite in [
            crate::convolution::SUITE,
            crate::subtractive::SUITE,
            crate::motion::SUITE,
            crate::budget::SUITE,
            crate::bumps::SUITE,
        ] {
            let names: Vec<_> = suite.experiments.iter().map(|experiment| experiment.name()).collect();
            for (index, name) in names.iter().enumerate() {
                assert!(!names[..index].contains(name), "{name}");
            }
            let wanted = [names[names.len() - 1].to_owned(), names[0].to_owned()];
            let chosen = suite.choose(&wanted).unwrap();
            assert_eq!(chosen[0].name(), names[0]);
            assert_eq!(suite.choose(&[]).unwrap().len(), names.len());
            let message = suite.choose(&["nonsense".to_owned()]).err().unwrap().to_string();
            assert!(message.contains("nonsense") && message.contains(names[0]), "{message}");
        }
    }
}
