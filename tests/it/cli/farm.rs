//! `caustica farm slurm`: with programs that stand for Slurm, and with a real Slurm.
#![cfg(unix)]

use super::{CliSandbox, ProgramRun, unframed_text};
use crate::support::{PATIENCE, project_path};
use std::fs;
use std::io::{BufRead, BufReader};
use std::os::unix::fs::PermissionsExt;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::time::{Duration, Instant};

/// Shell script that replaces sbatch: runs a job at once and records its state. Tasks that a line
/// of the file `failing` names, such as `1_2`, fail. If the file `refusing` exists, all jobs are
/// refused.
const SBATCH: &str = r#"#!/bin/sh
here=$(dirname "$0")
printf '%s\n' "$*" >>"$here/calls"
[ ! -e "$here/refusing" ] || { echo "sbatch: error: QOSMaxSubmitJobPerUserLimit" >&2; exit 1; }
array=
while [ $# -gt 0 ]; do
  case $1 in
    --chdir=*) cd "${1#*=}" || exit ;;
    --array=*) array=${1#*=} ;;
    -*) ;;
    *) break ;;
  esac
  shift
done
job=$(($(cat "$here/job" 2>/dev/null || echo 0) + 1))
echo $job >"$here/job"
run() {
  if grep -qx "$1" "$here/failing" 2>/dev/null; then
    echo "node on fire" >"log/$1.log"
    echo "$1|FAILED|NonZeroExitCode" >>"$here/tasks"
  elif SLURM_ARRAY_TASK_ID=$2 sh "$script" $offset >"log/$1.log" 2>&1; then
    echo "$1|COMPLETED|None" >>"$here/tasks"
  else
    echo "$1|FAILED|NonZeroExitCode" >>"$here/tasks"
  fi
}
script=$1 offset=${2:-}
if [ -z "$array" ]; then
  run $job ""
else
  for range in $(echo "$array" | tr , ' '); do
    for task in $(seq "${range%-*}" "${range#*-}"); do run "${job}_$task" "$task"; done
  done
fi
echo "$job;cluster"
"#;

/// Shell script that replaces squeue: prints the states of the requested jobs. If the file `active`
/// exists, it removes the file and reports that a job is running.
const SQUEUE: &str = r#"#!/bin/sh
here=$(dirname "$0")
for last; do :; done
[ ! -e "$here/active" ] || { rm "$here/active"; echo "${last%%,*}|RUNNING|None"; exit; }
found=
for job in $(echo "$last" | tr , ' '); do
  grep -E "^$job(_|\|)" "$here/tasks" 2>/dev/null && found=yes
done
[ -n "$found" ] || { echo "slurm_load_jobs error: Invalid job id specified" >&2; exit 1; }
"#;

/// A sandbox in which shell scripts replace the programs of Slurm.
struct FakeSlurm {
    sandbox: CliSandbox,
}

impl FakeSlurm {
    /// Returns a fake Slurm whose job arrays have at most `max_array_size` − 1 tasks.
    fn new(max_array_size: u32) -> Self {
        let sandbox = CliSandbox::new();
        fs::create_dir(sandbox.path("bin")).unwrap();
        let scontrol = format!("#!/bin/sh\necho 'MaxArraySize            = {max_array_size}'\n");
        for (name, text) in [("sbatch", SBATCH), ("squeue", SQUEUE), ("scontrol", &scontrol)] {
            sandbox.put(&format!("bin/{name}"), text);
            fs::set_permissions(sandbox.path(&format!("bin/{name}")), fs::Permissions::from_mode(0o755)).unwrap();
        }
        Self { sandbox }
    }

    /// Runs `caustica farm slurm` on the box with these words.
    fn farm(&self, words: &str) -> ProgramRun {
        let path = format!("{}:{}", self.sandbox.path("bin").display(), std::env::var("PATH").unwrap());
        farm(&self.sandbox, &path, words)
    }

    /// Makes the last jobs appear as running in the next call of squeue. After it, they have the
    /// states in the lines of `tasks`, or their real states if `tasks` is empty.
    fn let_jobs_end_later(&self, tasks: &str) {
        if !tasks.is_empty() {
            self.sandbox.put("bin/tasks", tasks);
        }
        self.sandbox.put("bin/active", "");
    }

    /// Returns the options of all calls of sbatch that begin with `start`, in their order.
    fn calls(&self, start: &str) -> Vec<String> {
        let calls = fs::read_to_string(self.sandbox.path("bin/calls")).unwrap_or_default();
        let words = calls.split_whitespace().filter(|word| word.starts_with(start));
        words.map(str::to_owned).collect()
    }
}

/// Runs `caustica farm slurm` on the box of a sandbox, with the programs of `path`.
fn farm(sandbox: &CliSandbox, path: &str, words: &str) -> ProgramRun {
    let mut command = assert_cmd::Command::new(env!("CARGO_BIN_EXE_caustica"));
    command.current_dir(sandbox.path(".")).env("PATH", path).timeout(PATIENCE);
    command.args(["farm", "slurm", "box.txt", "--photons", "1k", "--poll", "0"]).args(words.split_whitespace());
    let output = command.output().unwrap();
    ProgramRun {
        code: output.status.code(),
        stdout: String::from_utf8(output.stdout).unwrap(),
        stderr: unframed_text(&String::from_utf8(output.stderr).unwrap()),
    }
}

/// All shards and the merge are submitted, in job arrays of a size that Slurm allows. The picture
/// has the bits of one render. Running the same command again only merges.
#[test]
fn farm_renders_have_the_bits_of_one_render() {
    let slurm = FakeSlurm::new(4);
    let settings = "--seed 3 --spp 2 --size 40x30 --effects -caustics --crop 4,2,36,26 --clamp 2 --light-groups";
    let words = format!("--shards 5 --passes 12 -o out.exr -o all.film {settings}");
    let parts = ["submitted 5 shards as jobs 1, 2, and the merge as job 3", "12 passes", "estimated error"];
    slurm.farm(&words).expect(0, &parts);
    assert_eq!(slurm.calls("--array"), ["--array=1-3", "--array=1-2"]);
    assert_eq!(slurm.calls("--dependency"), ["--dependency=afterany:1:2"]);
    let sandbox = &slurm.sandbox;
    sandbox.render("box.txt", &format!("-o whole.exr --passes 12 --film whole.film {settings}")).expect(0, &[]);
    assert_eq!(sandbox.bytes("out.exr"), sandbox.bytes("whole.exr"));
    let [sum, whole] = ["all.film", "whole.film"].map(|film| {
        let text = sandbox.run(&["film", film]).stdout;
        text.lines()
            .filter(|line| !line.starts_with("time") && !line.starts_with("scene"))
            .collect::<Vec<_>>()
            .join("\n")
    });
    assert_eq!(sum, whole);
    slurm.farm(&words).expect(0, &["submitted the merge as job 4", "12 passes"]);
    assert_eq!(slurm.calls("--array").len(), 2);

    let parts = ["holds another render", "--spp 2 --effects -caustics", "--clamp 2 --crop 4,2,36,26"];
    slurm.farm(&words.replace("--spp 2", "--spp 3")).expect(2, &parts);
    let other_shards = words.replace("--shards 5", "--shards 4");
    slurm.farm(&other_shards).expect(2, &["12 passes in 4 shards here, 12 passes in 5 shards there"]);

    // A farm refuses `--aov`. A render that continues from the merged film writes the layers.
    slurm.farm(&format!("{words} --aov layers.exr")).expect(2, &["a farm does not take --aov", "merged.film"]);
    let layers = format!("--film out.exr.farm/merged.film --passes 12 --aov layers.exr --stats stats.json {settings}");
    let run = sandbox.render("box.txt", &layers);
    run.expect(0, &["continuing out.exr.farm/merged.film: 12 passes", "wrote layers.exr", "12 passes in"]);
    assert!(!run.stderr.contains("pass 13"), "{}", run.stderr);
}

#[test]
fn failed_shards_are_submitted_again() {
    let slurm = FakeSlurm::new(1001);
    let sandbox = &slurm.sandbox;
    sandbox.put("bin/failing", "1_2\n1_4\n3_4\n");
    let words = "--shards 4 --passes 8 -o out.exr";
    slurm.farm(words).expect(0, &["incomplete shards: 2,4;", "incomplete shards: 4;", "8 passes"]);
    assert_eq!(slurm.calls("--array"), ["--array=1-4", "--array=2,4", "--array=4"]);
    sandbox.render("box.txt", "-o whole.exr --passes 8 --photons 1k").expect(0, &[]);
    assert_eq!(sandbox.bytes("out.exr"), sandbox.bytes("whole.exr"));
}

/// A second command with other outputs waits for the jobs of the first one, then merges into its
/// own outputs.
#[test]
fn followed_jobs_merge_into_the_current_outputs() {
    let slurm = FakeSlurm::new(1001);
    let words = "--shards 2 --passes 4 --work-dir work";
    slurm.farm(&format!("{words} -o a.exr")).expect(0, &["4 passes"]);
    slurm.let_jobs_end_later("");
    slurm.farm(&format!("{words} -o b.exr")).expect(0, &["following jobs 1, 2", "the merge as job 3", "wrote b.exr"]);
    assert_eq!(slurm.sandbox.bytes("b.exr"), slurm.sandbox.bytes("a.exr"));
    slurm.let_jobs_end_later("");
    slurm.farm(&format!("{words} -o b.exr")).expect(0, &["following job 3", "4 passes"]);
    assert_eq!(slurm.calls("--chdir").len(), 3);
}

#[test]
fn a_cancelled_followed_job_ends_the_farm() {
    let slurm = FakeSlurm::new(1001);
    slurm.sandbox.put("bin/failing", "1_2\n3_2\n");
    let words = "--shards 2 --passes 4 -o a.exr --retries 0";
    slurm.farm(words).expect(5, &["there are incomplete shards (2)"]);
    slurm.let_jobs_end_later("3_2|CANCELLED|None\n");
    slurm.farm(words).expect(5, &["following jobs 3, 4", "1 job was cancelled; incomplete shards: 2"]);
    assert_eq!(slurm.calls("--chdir").len(), 4);
}

/// A shard that keeps failing ends the command after `--retries` rounds without a new pass. When
/// the cause is removed, the same command continues.
#[test]
fn shards_that_keep_failing_end_the_farm() {
    let slurm = FakeSlurm::new(1001);
    let failing: String = (1..20).map(|job| format!("{job}_3\n")).collect();
    slurm.sandbox.put("bin/failing", failing);
    let words = "--shards 3 --passes 6 -o out.exr --retries 1";
    let parts =
        ["there are incomplete shards (3) after 2 rounds without a new pass", "node on fire", "same command again"];
    slurm.farm(words).expect(5, &parts);
    assert_eq!(slurm.calls("--array"), ["--array=1-3", "--array=3", "--array=3"]);
    fs::remove_file(slurm.sandbox.path("bin/failing")).unwrap();
    slurm.farm(words).expect(0, &["submitted 1 shard as job 7", "6 passes"]);
}

/// Further waves of shards are submitted until the estimated error is low enough, or the maximum
/// number of passes is reached. The picture has the bits of one render of these passes.
#[test]
#[ignore = "long: many runs of the program"]
fn waves_follow_until_the_error_is_reached() {
    let slurm = FakeSlurm::new(1001);
    let words = "--shards 2 --passes 7 -o out.exr --target-error 4%";
    slurm.farm(words).expect(0, &["the next wave has", "the error is at most 4.0 % with 90 % confidence"]);
    let sandbox = &slurm.sandbox;
    let film = sandbox.run(&["film", "out.exr.farm/merged.film"]);
    let passes: u32 = film.stdout.split("passes    ").nth(1).unwrap().split(':').next().unwrap().parse().unwrap();
    assert!(passes > 8 && passes.is_multiple_of(4), "{passes}");
    sandbox.render("box.txt", &format!("-o whole.exr --passes {passes} --photons 1k")).expect(0, &[]);
    assert_eq!(sandbox.bytes("out.exr"), sandbox.bytes("whole.exr"));
    let limited = "--shards 2 --passes 4 -o few.exr --target-error 0.1% --max-passes 7";
    slurm.farm(limited).expect(0, &["a further wave would exceed 7 passes", "6 passes"]);
}

#[test]
fn invalid_farms_are_refused_before_submission() {
    let slurm = FakeSlurm::new(1001);
    let sandbox = &slurm.sandbox;
    let all = "--shards 2 --passes 4";
    farm(sandbox, "/nonexistent", &format!("{all} -o a.exr")).expect(5, &["no program `scontrol`", "--dry-run"]);
    slurm.farm("--shards 5 --passes 4 -o a.exr").expect(2, &["5 shards are too many for 4 passes"]);
    slurm.farm(&format!("{all} -o none/a.exr")).expect(3, &["no folder `none`"]);
    slurm.farm(&format!("{all} -o a.exr --work-dir .")).expect(2, &["is not empty", "choose another --work-dir"]);
    let raycast = format!("{all} -o a.exr --integrator raycast --target-error 1%");
    slurm.farm(&raycast).expect(2, &["--target-error needs an error estimate"]);
    let raycast = format!("{all} -o a.exr --integrator raycast --light-groups");
    slurm.farm(&raycast).expect(2, &["--light-groups needs light that is simulated"]);
    slurm
        .farm(&format!("{all} -o a.exr --crop 0,0,99,9"))
        .expect(2, &["0,0,99,9 exceeds the picture of 40 × 30 pixels"]);
    sandbox.put("copy.exr", super::BOX);
    fs::remove_file(sandbox.path("box.txt")).unwrap();
    std::os::unix::fs::symlink("copy.exr", sandbox.path("box.txt")).unwrap();
    slurm.farm(&format!("{all} -o copy.exr")).expect(2, &["are the same file"]);
    assert_eq!(slurm.calls("--"), [""; 0]);
    sandbox.put("bin/refusing", "");
    slurm.farm(&format!("{all} -o a.exr")).expect(5, &["`sbatch` refuses", "QOSMaxSubmitJobPerUserLimit"]);
    fs::remove_file(sandbox.path("bin/refusing")).unwrap();
    slurm.farm(&format!("{all} -o a.exr")).expect(0, &["4 passes"]);
    sandbox.put("bin/scontrol", "#!/bin/sh\necho 'MaxArraySize = 0'\n");
    slurm.farm(&format!("{all} -o b.exr")).expect(5, &["allows no job arrays"]);
}

/// `--dry-run` prints scripts that a shell reads, with absolute paths, and changes nothing.
#[test]
fn dry_runs_print_both_scripts() {
    let sandbox = CliSandbox::new();
    let more = "--shards 2500 --passes 9k -o a.exr --partition fast --time-limit 2:00:00 --memory 3G --threads 4 \
                --work-dir it's --sbatch=--constraint=zen4";
    let run = farm(&sandbox, "/nonexistent", &format!("{more} --dry-run"));
    run.expect(0, &[]);
    assert_eq!(sandbox.names(), ["box.txt"]);
    let here = fs::canonicalize(sandbox.path(".")).unwrap();
    let lines = [
        "#SBATCH --cpus-per-task=4".to_owned(),
        "#SBATCH --mem=2862M".to_owned(),
        "#SBATCH --partition=fast".to_owned(),
        "#SBATCH --time=2:00:00".to_owned(),
        "#SBATCH --constraint=zen4".to_owned(),
        format!("cd '{}/it'\\''s' || exit", here.display()),
        format!("render {}/box.txt --passes 9000 --threads 4 --seed 0", here.display()),
        format!("merge shard-*.film -o merged.film -o {}/a.exr", here.display()),
        "--array=1-500 ".to_owned(),
        "--dependency=afterany:ARRAY1:ARRAY2:ARRAY3 ".to_owned(),
    ];
    for line in lines {
        assert!(run.stdout.contains(&line), "`{line}` is not in:\n{}", run.stdout);
    }
    let checked = Command::new("sh").args(["-n", "-c", &run.stdout]).status().unwrap();
    assert!(checked.success());
}

/// The merge holds two films at a time, so its limit may exceed that of a shard.
#[test]
fn merges_ask_for_the_memory_of_two_films() {
    let sandbox = CliSandbox::new();
    // A film of this size takes 56 MB.
    let words = "--shards 2 --passes 4 -o a.exr --size 400x300 --memory 75M --dry-run";
    let run = farm(&sandbox, "/nonexistent", words);
    run.expect(0, &[]);
    let numbers = |before: &str, after: char| -> Vec<u64> {
        let parts = run.stdout.split(before).skip(1);
        parts.map(|part| part.split(after).next().unwrap().trim().parse().unwrap()).collect()
    };
    let (jobs, limits) = (numbers("#SBATCH --mem=", 'M'), numbers(" --memory ", ' '));
    assert_eq!((jobs[0], limits[0], jobs.len(), limits.len()), (72, 75_000_000, 2, 2));
    assert!(limits[1] > 130_000_000 && limits[1] < 200_000_000, "{limits:?}");
    assert_eq!(jobs[1], limits[1].div_ceil(1 << 20));
}

/// A running Slurm cluster of one node. Dropping this value ends the cluster.
struct Cluster {
    script: Child,
    /// The script stops the daemons when its standard input ends.
    input: Option<ChildStdin>,
    folder: tempfile::TempDir,
}

impl Cluster {
    /// Starts a cluster; `None` if this machine cannot run Slurm.
    fn start() -> Option<Self> {
        let folder = tempfile::tempdir().unwrap();
        let mut script = Command::new("bash")
            .arg(project_path("tests/farm/slurm.sh"))
            .arg(folder.path())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let (input, output) = (script.stdin.take(), script.stdout.take().unwrap());
        let mut line = String::new();
        BufReader::new(output).read_line(&mut line).unwrap();
        if line.trim() == "ready" {
            return Some(Self { script, input, folder });
        }
        assert_eq!(script.wait().unwrap().code(), Some(77), "the cluster did not start");
        None
    }

    /// Returns a command that talks to this cluster.
    fn command(&self, program: &str, words: &str) -> Command {
        let mut command = Command::new(program);
        command.env("SLURM_CONF", self.folder.path().join("slurm.conf")).args(words.split_whitespace());
        command
    }

    /// Runs a command, and returns its standard output.
    fn output(&self, program: &str, words: &str) -> String {
        let output = self.command(program, words).output().unwrap();
        assert!(output.status.success(), "{program} {words}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    }

    /// Waits until squeue prints `line` about a task.
    fn wait_for(&self, line: &str) {
        let start = Instant::now();
        while !self.output("squeue", "--noheader --array --states=all --format=%i|%T").lines().any(|own| own == line) {
            assert!(start.elapsed() < PATIENCE, "`{line}` did not come");
            std::thread::sleep(Duration::from_millis(50));
        }
    }
}

impl Drop for Cluster {
    fn drop(&mut self) {
        drop(self.input.take());
        let _ = self.script.wait();
    }
}

/// A render by a real Slurm survives a killed and a requeued shard with the bits of one local run.
#[test]
#[ignore = "long: starts a Slurm cluster"]
fn slurm_survives_killed_and_requeued_shards() {
    let Some(cluster) = Cluster::start() else {
        eprintln!("SKIPPED: this machine cannot run Slurm");
        return;
    };
    let sandbox = CliSandbox::new();
    let words = "farm slurm box.txt --shards 6 --passes 300 -o out.exr --photons 1k --poll 0.2s --save-every 0";
    let mut farm = cluster.command(env!("CARGO_BIN_EXE_caustica"), words);
    let log = fs::File::create(sandbox.path("farm.log")).unwrap();
    let mut farm = farm.current_dir(sandbox.path(".")).stderr(log).spawn().unwrap();
    for task in [2, 4] {
        cluster.wait_for(&format!("1_{task}|RUNNING"));
        while !sandbox.path(&format!("out.exr.farm/shard-00000{task}.film")).exists() {
            std::thread::sleep(Duration::from_millis(20));
        }
    }
    // The script of a task is replaced by the render, so that the signal kills the render itself.
    cluster.output("scancel", "--batch --signal=KILL 1_2");
    cluster.output("scontrol", "requeue 1_4");
    cluster.wait_for("1_2|FAILED");
    // Slurm delays requeued tasks for two minutes. The pause is needed because slurmd refuses to
    // start a task in the same second in which it revoked the credential of its first start.
    cluster.wait_for("1_4|PENDING");
    std::thread::sleep(Duration::from_secs(3));
    cluster.output("scontrol", "update JobId=1_4 StartTime=now");
    let ended = farm.wait().unwrap();
    let log = fs::read_to_string(sandbox.path("farm.log")).unwrap();
    let restarted = fs::read_to_string(sandbox.path("out.exr.farm/log/1_4.log")).unwrap();
    println!("{log}\nThe log of the requeued shard:\n{restarted}");
    assert!(ended.success(), "{log}");
    for part in
        ["submitted 6 shards as job 1, and the merge as job 2", "1 failed", "incomplete shards: 2;", "300 passes"]
    {
        assert!(log.contains(part), "`{part}` is not in:\n{log}");
    }
    assert!(restarted.contains("shard 4 of 6, start 1") && restarted.contains("continuing shard-000004.film"));
    sandbox.render("box.txt", "-o whole.exr --passes 300 --photons 1k -q").expect(0, &[]);
    assert_eq!(sandbox.bytes("out.exr"), sandbox.bytes("whole.exr"));
}
