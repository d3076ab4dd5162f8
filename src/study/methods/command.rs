//! Shell commands that repeat a study or render one of its pictures again.

use super::MethodVariant;

/// Scene of a study, and the command that repeats the study.
#[derive(Clone, Debug, Default)]
pub struct StudiedScene {
    /// Path of the studied scene file.
    pub scene_path: String,
    /// Width and height of the study's pictures \[pixels]; `None` for the size that the scene
    /// defines.
    pub size: Option<(u32, u32)>,
    /// Flags that say how to read the scene file, such as `--allow-outside`.
    pub import_flags: Vec<String>,
    /// Shell command that repeats the study.
    pub study_command: String,
}

impl StudiedScene {
    /// Returns the shell command that renders `passes` passes of `variant`. The rendered picture
    /// equals the picture of the study's first seed, bit for bit.
    pub(super) fn render_command_line(&self, variant: &MethodVariant, passes: u32) -> String {
        let mut words = ["caustica", "render"].map(str::to_owned).to_vec();
        // Prefix a path that begins with a dash: it would be parsed as a flag.
        words.push(if self.scene_path.starts_with('-') {
            format!("./{}", self.scene_path)
        } else {
            self.scene_path.clone()
        });
        words.extend(self.import_flags.iter().cloned());
        if let Some((width, height)) = self.size {
            words.extend(["--size".to_owned(), format!("{width}x{height}")]);
        }
        words.extend(variant.flags.iter().cloned());
        words.extend(["--seed".to_owned(), variant.settings.camera_paths.seed.to_string()]);
        words.extend(["--passes".to_owned(), passes.to_string()]);
        words.extend(["-o".to_owned(), format!("{}.exr", label_to_file_name(&variant.label))]);
        shell_command_line(&words)
    }
}

/// Returns a file name made from `label`, without an extension. Each run of characters other than
/// ASCII letters, digits and dots becomes one dash; at the start and the end, such a run is
/// removed.
fn label_to_file_name(label: &str) -> String {
    let parts = label.split(|c: char| !(c.is_ascii_alphanumeric() || c == '.')).filter(|part| !part.is_empty());
    parts.collect::<Vec<_>>().join("-")
}

/// Joins `words` to a command line, with quotes for a POSIX shell where necessary.
#[must_use]
pub fn shell_command_line(words: &[String]) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "_@%+=:,./-".contains(c);
    let quoted = |word: &String| {
        if !word.is_empty() && word.chars().all(plain) {
            word.clone()
        } else {
            format!("'{}'", word.replace('\'', r"'\''"))
        }
    };
    words.iter().map(quoted).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrate::{Algorithm, Settings};

    #[test]
    fn render_commands_are_quoted_for_shells() {
        let mut settings = Settings::default();
        settings.camera_paths.seed = 7;
        let flags = ["--integrator", "sppm", "--gather-k", "20"].map(str::to_owned).to_vec();
        let variant = MethodVariant { label: "sppm --gather-k 20".into(), algorithm: Algorithm::Sppm, settings, flags };
        let subject =
            |scene: &str| StudiedScene { scene_path: scene.into(), size: Some((4, 3)), ..StudiedScene::default() };
        let rest = "--size 4x3 --integrator sppm --gather-k 20 --seed 7 --passes 5 -o sppm-gather-k-20.exr";
        assert_eq!(subject("a/b.txt").render_command_line(&variant, 5), format!("caustica render a/b.txt {rest}"));
        assert_eq!(
            subject("it's $1.txt").render_command_line(&variant, 5),
            format!(r"caustica render 'it'\''s $1.txt' {rest}")
        );
        assert_eq!(subject("-x.txt").render_command_line(&variant, 5), format!("caustica render ./-x.txt {rest}"));
        let outside = StudiedScene { import_flags: vec!["--allow-outside".into()], ..subject("a.pbrt") };
        let expected = format!("caustica render a.pbrt --allow-outside {rest}");
        assert_eq!(outside.render_command_line(&variant, 5), expected);
        assert_eq!(shell_command_line(&[String::new()]), "''");
    }
}
