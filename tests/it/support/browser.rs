//! A headless browser that opens report pages.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Time limit of one browser run. A page loads in seconds; a test fails if its browser hangs.
const LIMIT: Duration = Duration::from_secs(120);

pub struct Browser {
    program: PathBuf,
    folder: tempfile::TempDir,
}

/// Contents of a page after it was loaded.
pub struct LoadedPage {
    /// The document's elements after its scripts ran, as HTML.
    pub dom: String,
    /// Lines that the page wrote to the browser's console.
    pub complaints: Vec<String>,
    /// Screenshot of the window, row by row, as sRGB bytes.
    pub pixels: Vec<[u8; 3]>,
}

/// Returns the path of a browser: `CAUSTICA_CHROMIUM`, or the first Chromium or Chrome in PATH.
///
/// `None` if there is none.
pub fn find_browser() -> Option<PathBuf> {
    if let Some(program) = std::env::var_os("CAUSTICA_CHROMIUM") {
        return Some(program.into());
    }
    let path = std::env::var_os("PATH")?;
    let names = ["chromium", "chromium-browser", "google-chrome"];
    std::env::split_paths(&path)
        .flat_map(|folder| names.map(|name| folder.join(name)))
        .find(|program| program.is_file())
}

impl Browser {
    /// Returns the browser that [`find_browser`] finds, with a temporary profile; `None` if there
    /// is none.
    pub fn find() -> Option<Self> {
        Some(Self { program: find_browser()?, folder: tempfile::tempdir().unwrap() })
    }

    /// Writes `page` to the file `name` and opens it in a window of the given size.
    ///
    /// `fragment` is appended to the URL.
    pub fn open(&self, name: &str, page: &str, fragment: &str, (width, height): (u32, u32)) -> LoadedPage {
        let path = self.folder.path().join(name);
        fs::write(&path, page).unwrap();
        let address = format!("file://{}{fragment}", path.display());
        let screenshot = self.folder.path().join("screenshot.png");
        let size = format!("--window-size={width},{height}");
        let (_, complaints) = self.run(&[&size, &format!("--screenshot={}", screenshot.display()), &address]);
        let (dom, _) = self.run(&[&size, "--dump-dom", &address]);
        LoadedPage { dom, complaints, pixels: pixels(&screenshot) }
    }

    /// Runs the browser once. Returns its standard output, and the lines that pages wrote to its
    /// console.
    fn run(&self, arguments: &[&str]) -> (String, Vec<String>) {
        let [out, error] = ["out", "error"].map(|name| self.folder.path().join(name));
        let profile = format!("--user-data-dir={}", self.folder.path().join("profile").display());
        let mut child = Command::new(&self.program)
            .args(["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--virtual-time-budget=5000"])
            .args(["--enable-logging=stderr", "--no-first-run", "--disable-dev-shm-usage", &profile])
            .args(arguments)
            .stdin(Stdio::null())
            .stdout(fs::File::create(&out).unwrap())
            .stderr(fs::File::create(&error).unwrap())
            .spawn()
            .unwrap();
        let start = Instant::now();
        let status = loop {
            if let Some(status) = child.try_wait().unwrap() {
                break status;
            }
            if start.elapsed() > LIMIT {
                child.kill().unwrap();
                child.wait().unwrap();
                panic!("the browser did not end: {}", fs::read_to_string(&error).unwrap());
            }
            std::thread::sleep(Duration::from_millis(20));
        };
        let [out, error] = [out, error].map(|path| String::from_utf8_lossy(&fs::read(path).unwrap()).into_owned());
        assert!(status.success(), "{error}");
        let complaints = error.lines().filter(|line| line.contains("CONSOLE")).map(str::to_owned).collect();
        (out, complaints)
    }
}

fn pixels(path: &std::path::Path) -> Vec<[u8; 3]> {
    let mut reader = png::Decoder::new(std::io::BufReader::new(fs::File::open(path).unwrap())).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    let channels = info.color_type.samples();
    bytes[..info.buffer_size()].chunks_exact(channels).map(|p| [p[0], p[1], p[2]]).collect()
}
