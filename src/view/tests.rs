use super::*;
use crate::camera::Camera;
use crate::image::Image;
use crate::integrate::{Algorithm, LightGroup, Settings, SilentMonitor, SurfaceAovs};
use crate::render::{RenderResult, StopCriteria, render};
use crate::scene::{Material, Scene, SceneBuilder};
use crate::shape::{Shape, Sphere};
use glam::{DVec3, Vec2, Vec3};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Live page and its web server under test. Collects the requests of browsers.
struct ServedPage {
    page: Arc<LivePage>,
    server: PageServer,
    address: SocketAddr,
    /// URL path of the page: the token between slashes.
    root: String,
    requests: Arc<Mutex<Vec<Request>>>,
}

/// HTTP status code, headers and body of a response.
struct HttpAnswer {
    code: u16,
    head: String,
    body: Vec<u8>,
}

impl ServedPage {
    fn start() -> Self {
        Self::with_reference(None)
    }

    fn with_reference(reference: Option<LiveFrame>) -> Self {
        let page = Arc::new(LivePage::new("a b/scene.txt".to_owned(), "path", true, reference));
        let requests = Arc::<Mutex<Vec<Request>>>::default();
        let list = requests.clone();
        let take = move |request| {
            list.lock().unwrap().push(request);
            request != Request::Resume
        };
        let server = PageServer::start(ListenAddress::default(), page.clone(), Box::new(take)).unwrap();
        let rest = server.url().strip_prefix("http://").unwrap().to_owned();
        let (address, token) = rest.split_once('/').unwrap();
        let (address, root) = (address.parse().unwrap(), format!("/{token}"));
        Self { page, server, address, root, requests }
    }

    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(self.address).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        stream
    }

    /// Sends a request line with headers and a body.
    fn send(&self, line: &str, headers: &str, body: &str) -> HttpAnswer {
        let mut stream = self.connect();
        let length = body.len();
        // The server may refuse a body before it has read all of it. Then it closes the connection,
        // and both calls may fail although the answer has arrived.
        _ = write!(stream, "{line} HTTP/1.1\r\n{headers}Connection: close\r\nContent-Length: {length}\r\n\r\n{body}");
        let mut bytes = Vec::new();
        _ = stream.read_to_end(&mut bytes);
        let end = bytes.windows(4).position(|four| four == b"\r\n\r\n").unwrap();
        let head = String::from_utf8(bytes[..end].to_vec()).unwrap();
        HttpAnswer { code: head[9..12].parse().unwrap(), head: head.to_lowercase(), body: bytes[end + 4..].to_vec() }
    }

    fn host(&self) -> String {
        format!("Host: {}\r\n", self.address)
    }

    /// Requests a path below that of the page.
    fn get(&self, path: &str) -> HttpAnswer {
        self.send(&format!("GET {}{path}", self.root), &self.host(), "")
    }

    fn post(&self, path: &str, body: &str) -> HttpAnswer {
        let headers = format!("{}Origin: http://{}\r\n", self.host(), self.address);
        self.send(&format!("POST {}{path}", self.root), &headers, body)
    }

    /// Opens the stream of server-sent events, which carries the states of the render.
    fn events(&self) -> BufReader<TcpStream> {
        let mut stream = self.connect();
        write!(stream, "GET {}events HTTP/1.1\r\n{}\r\n", self.root, self.host()).unwrap();
        BufReader::new(stream)
    }

    /// Publishes a picture whose pixels all have the given radiance. `number` is the number of the
    /// render.
    fn show(&self, number: u32, size: (u32, u32), radiance: f32) {
        self.page.publish(number, |state, sequence| {
            let pixels = vec![Vec3::new(radiance, 0.5 * radiance, -radiance); (size.0 * size.1) as usize];
            state.picture = Some(Arc::new(LiveFrame::from_picture(sequence, size, 7, &pixels)));
        });
    }
}

/// Reads the next state of the render, as JSON, from a stream of server-sent events.
fn next_state(events: &mut impl BufRead) -> serde_json::Value {
    let mut line = String::new();
    loop {
        line.clear();
        assert!(events.read_line(&mut line).unwrap() > 0, "the stream has ended");
        if let Some(json) = line.strip_prefix("data: ") {
            return serde_json::from_str(json).unwrap();
        }
    }
}

/// Decodes the bytes of [`LiveFrame::encoded_layer`]. Returns \[sequence number, width, height,
/// channels] and the values.
fn decode(bytes: &[u8]) -> ([u32; 4], Vec<f32>) {
    let number = |i: usize| u32::from_le_bytes(bytes[4 * i..][..4].try_into().unwrap());
    let scale = f32::from_bits(number(4));
    let (values, count) = (&bytes[frame::HEADER_BYTES..], number(1) * number(2) * number(3));
    let values = if values.len() == 4 * count as usize {
        values.as_chunks().0.iter().map(|single| f32::from_le_bytes(*single) * scale).collect()
    } else {
        values.as_chunks().0.iter().map(|half| half::f16::from_le_bytes(*half).to_f32() * scale).collect()
    };
    ([0, 1, 2, 3].map(number), values)
}

/// Returns a scene with an emitting sphere, and a camera of 24 × 16 pixels.
fn scene_with_emitting_sphere() -> Scene {
    let mut builder = SceneBuilder::new();
    let white = builder.add_material(Material::diffuse(Vec3::splat(0.5)));
    builder.add_shape(Shape::Sphere(Sphere::new(DVec3::new(0.0, 0.0, -4.0), 1.0)), white, Vec3::ONE);
    builder.add_shape(Shape::Sphere(Sphere::new(DVec3::new(0.0, -11.0, -4.0), 10.0)), white, Vec3::ZERO);
    builder.build(Camera::perspective(DVec3::ZERO, -DVec3::Z, DVec3::Y, 0.7, 24, 16).unwrap()).unwrap()
}

#[test]
fn foreign_requests_are_refused() {
    let served = ServedPage::start();
    let (own, root) = (served.host(), served.root.clone());
    assert_eq!(served.get("").code, 200);
    let refused = |line: &str, headers: &str| served.send(line, headers, "").code;
    assert_eq!(refused("GET /", &own), 403);
    assert_eq!(refused("GET /events", &own), 403);
    assert_eq!(refused(&format!("GET /0{}", &root[1..]), &own), 403);
    let port = served.address.port();
    assert_eq!(refused(&format!("GET {root}"), &format!("Host: evil.example:{port}\r\n")), 403);
    assert_eq!(refused(&format!("GET {root}"), &format!("Host: localhost:{port}\r\n")), 200);
    let foreign = format!("{own}Origin: http://evil.example\r\n");
    assert_eq!(refused(&format!("POST {root}request/stop"), &foreign), 403);
    assert!(served.requests.lock().unwrap().is_empty());
    assert_eq!(served.post("request/stop", "").code, 204);
    assert_eq!(served.post("request/resume", "").code, 409);
    assert_eq!(served.post("request/format", "").code, 400);
    assert_eq!(served.post("request/orbit", "{\"yaw\": 1, \"pitch\": 0.5, \"zoom\": 0}").code, 204);
    assert_eq!(served.post("request/orbit", "{\"yaw\": \"x\"}").code, 400);
    assert_eq!(served.post("request/stop", &"x".repeat(1 << 20)).code, 413);
    let orbit = Request::Orbit(Orbit { yaw: 1.0, pitch: 0.5, log_distance: 0.0 });
    assert_eq!(*served.requests.lock().unwrap(), [Request::Stop, Request::Resume, orbit]);
}

#[test]
fn page_loads_nothing_from_other_servers() {
    let served = ServedPage::start();
    let answer = served.get("");
    let page = String::from_utf8(answer.body).unwrap();
    for address in ["http://", "https://", "src=", "@import", "{nonce}", "{style}", "{script}"] {
        assert!(!page.replace("http://www.w3.org/2000/svg", "").contains(address), "{address}");
    }
    assert!(answer.head.contains("content-security-policy: default-src 'none'"), "{}", answer.head);
    assert!(answer.head.contains("cache-control: no-store"), "{}", answer.head);
    let nonce = answer.head.split("'nonce-").nth(1).unwrap().split('\'').next().unwrap();
    assert_eq!(page.matches(&format!("nonce=\"{nonce}\"")).count(), 2);
    // Identifiers that scripts look up exist.
    for id in page.split("byId(\"").skip(1).map(|part| part.split('"').next().unwrap()) {
        assert!(page.contains(&format!("id=\"{id}\"")), "{id}");
    }
    for kind in LayerKind::ALL {
        let name = kind.url_name();
        assert!(page.contains(&format!("\"{name}\":")) || page.contains(&format!("  {name}:")), "{name}");
    }
}

#[test]
fn readers_receive_the_newest_state() {
    let served = ServedPage::start();
    let mut events = served.events();
    assert_eq!(next_state(&mut events)["render"], 0);
    let number = served.page.begin_render();
    assert_eq!(next_state(&mut events)["render"], 1);
    served.show(number, (2, 1), 1.0);
    let state = next_state(&mut events);
    assert_eq!((&state["picture"]["width"], &state["picture"]["passes"]), (&2.into(), &7.into()));
    // A publication of an earlier render is ignored.
    let next = served.page.begin_render();
    served.show(number, (3, 3), 1.0);
    served.show(next, (4, 1), 1.0);
    let last = std::iter::from_fn(|| Some(next_state(&mut events))).find(|state| state["picture"]["width"] == 4);
    assert_eq!(last.unwrap()["render"], 2);
    // Late readers receive the newest state at once.
    assert_eq!(next_state(&mut served.events())["picture"]["width"], 4);
}

#[test]
fn encoded_layers_keep_three_digits() {
    let radiances = [0.0, 1.0, 1e-4, 123.456, 65_504.0, 3e7, -2.5, f32::INFINITY, f32::NAN];
    let pixels: Vec<Vec3> = radiances.iter().map(|value| Vec3::splat(*value)).collect();
    let frame = LiveFrame::from_picture(9, (3, 3), 1, &pixels);
    let (head, values) = decode(&frame.encoded_layer(LayerKind::Picture).unwrap());
    assert_eq!(head, [9, 3, 3, 3]);
    for (i, radiance) in radiances.iter().enumerate() {
        let value = values[3 * i + 1];
        let exact = value == *radiance || (value.is_nan() && radiance.is_nan());
        assert!(
            exact || (value / radiance - 1.0).abs() < 1.0 / 2048.0 || radiance.abs() < 3e7 / 2e9,
            "{radiance} {value}"
        );
    }
    for scale in [1e-30, 1e-42, 1e30, 3e38] {
        let frame = LiveFrame::from_picture(1, (1, 1), 1, &[Vec3::splat(scale)]);
        let (_, values) = decode(&frame.encoded_layer(LayerKind::Picture).unwrap());
        assert!((values[0] / scale - 1.0).abs() < 1.0 / 2048.0 || scale < f32::MIN_POSITIVE, "{scale} {}", values[0]);
    }
    assert!(frame.encoded_layer(LayerKind::Noise).is_none());
}

#[test]
fn error_maps_are_made_only_on_request() {
    let served = ServedPage::start();
    let number = served.page.begin_render();
    served.show(number, (2, 1), 0.25);
    assert!(!served.page.take_error_map_request());
    let picture = served.get("layer/picture");
    let (head, values) = decode(&picture.body);
    assert_eq!((&head[1..], &values[..3]), (&[2, 1, 3][..], &[0.25, 0.125, -0.25][..]));
    assert_eq!(served.get(&format!("layer/picture?after={}", head[0])).code, 204);
    assert_eq!(served.get(&format!("layer/picture?after={}", head[0] - 1)).code, 200);
    assert!(!served.page.take_error_map_request());
    assert_eq!(served.get("layer/noise").code, 204);
    assert!(served.page.take_error_map_request() && !served.page.take_error_map_request());
    assert!(!served.page.take_surface_aov_request());
    assert_eq!(served.get("layer/depth").code, 204);
    assert!(served.page.take_surface_aov_request() && !served.page.take_surface_aov_request());
    assert_eq!(served.get("layer/secret").code, 404);
    assert_eq!(served.get("layer/reference").code, 404);
    let reference = Image::from_pixels(1, 1, vec![Vec3::splat(2.0)]).unwrap();
    let served = ServedPage::with_reference(Some(LiveFrame::from_image(&reference)));
    assert_eq!(decode(&served.get("layer/reference").body).1, [2.0; 3]);
}

#[test]
fn surface_layers_hold_the_aovs() {
    let served = ServedPage::start();
    let live = RenderPublisher::begin(&served.page, Instant::now());
    served.show(live.render_number(), (2, 1), 0.25);
    let aovs = SurfaceAovs {
        albedo: vec![Vec3::new(0.5, 0.25, 0.125), Vec3::ZERO],
        normal: vec![Vec3::Y, Vec3::ZERO],
        depth: vec![2.0, 0.0],
        position: vec![Vec3::new(1.0, 2.0, -4.0), Vec3::ZERO],
        object_id: vec![70_001, 0],
        material_id: vec![1, 0],
        motion: vec![Vec2::new(4.0, -2.0), Vec2::ZERO],
    };
    live.publish_wanted_surface_aovs((2, 1), || panic!("no browser has asked for them"));
    assert_eq!(served.get("layer/motion").code, 204);
    live.publish_wanted_surface_aovs((2, 1), || Some(aovs));
    let first_pixel = |name: &str| {
        let ([_, width, height, channels], values) = decode(&served.get(&format!("layer/{name}")).body);
        assert_eq!((width, height, values.len()), (2, 1, 2 * channels as usize), "{name}");
        values[..channels as usize].to_vec()
    };
    assert_eq!(first_pixel("albedo"), [0.5, 0.25, 0.125]);
    assert_eq!((first_pixel("normal"), first_pixel("position")), (vec![0.0, 1.0, 0.0], vec![1.0, 2.0, -4.0]));
    assert_eq!((first_pixel("depth"), first_pixel("motion")), (vec![2.0], vec![4.0, -2.0]));
    assert_eq!((first_pixel("object"), first_pixel("material")), (vec![70_001.0], vec![1.0]));
    assert!(!served.page.take_surface_aov_request(), "they exist");
    served.page.begin_render();
    assert_eq!(served.get("layer/albedo").code, 204, "those of an earlier render are gone");
}

#[test]
fn saved_files_hold_the_newest_picture() {
    let served = ServedPage::start();
    assert_eq!(served.get("save/picture.png").code, 404);
    let number = served.page.begin_render();
    served.show(number, (2, 1), 0.3);
    let folder = tempfile::tempdir().unwrap();
    let exr = served.get("save/picture.exr");
    assert!(exr.head.contains("filename=\"scene-7.exr\""), "{}", exr.head);
    std::fs::write(folder.path().join("a.exr"), &exr.body).unwrap();
    let image = crate::image::read(&folder.path().join("a.exr")).unwrap();
    assert_eq!(image.pixels(), [Vec3::new(0.3, 0.15, -0.3); 2]);
    let png = served.get("save/picture.png?exposure=1&tone=course");
    std::fs::write(folder.path().join("a.png"), &png.body).unwrap();
    let tone = crate::image::ToneMap { curve: crate::image::ToneCurve::Legacy, exposure_stops: 1.0 };
    let metadata = vec![("Software".to_owned(), format!("Caustica {}", env!("CARGO_PKG_VERSION")))];
    let options = crate::image::WriteOptions { tone, metadata, ..Default::default() };
    let expected = crate::image::encode(crate::image::OutputFormat::Png, &image, &options).unwrap().0;
    assert!(png.body == expected);
    for wrong in ["save/picture.jpg", "save/picture.png?tone=x", "save/picture.png?exposure=999"] {
        assert_eq!(served.get(wrong).code, 400, "{wrong}");
    }
}

#[test]
fn slow_readers_never_delay_publications() {
    let served = ServedPage::start();
    let number = served.page.begin_render();
    served.show(number, (1000, 1000), 1.0);
    // Clients that ask for states and pixels and never read them.
    let silent: Vec<TcpStream> = (0..24)
        .flat_map(|_| {
            ["events", "layer/picture"].map(|path| {
                let mut stream = served.connect();
                write!(stream, "GET {}{path} HTTP/1.1\r\n{}\r\n", served.root, served.host()).unwrap();
                stream
            })
        })
        .collect();
    while served.page.reader_count() < 24 {
        std::thread::sleep(Duration::from_millis(1));
    }
    let start = Instant::now();
    for _ in 0..2000 {
        served.page.publish(number, |state, _| state.status.passes += 1);
    }
    let seconds = start.elapsed().as_secs_f64();
    assert!(seconds < 2.0, "2000 publications took {seconds} s");
    // Another reader still receives the last state.
    assert_eq!(next_state(&mut served.events())["passes"], 2000);
    drop(silent);
    let start = Instant::now();
    while served.page.reader_count() > 0 && start.elapsed() < Duration::from_secs(20) {
        served.page.publish(number, |state, _| state.status.passes += 1);
        std::thread::sleep(Duration::from_millis(10));
    }
    assert_eq!(served.page.reader_count(), 0, "readers that went away are forgotten");
}

#[test]
fn server_ends_despite_open_connections() {
    let served = ServedPage::start();
    let mut events = served.events();
    next_state(&mut events);
    let _silent = served.connect();
    let number = served.page.begin_render();
    served.page.publish(number, |state, _| state.status.stage = RenderStage::Ended);
    let start = Instant::now();
    served.server.finish();
    assert!(start.elapsed() < Duration::from_secs(5));
    let last = std::iter::from_fn(|| Some(next_state(&mut events))).find(|state| state["phase"] == "ended");
    assert!(last.is_some());
}

#[test]
fn publishing_does_not_change_the_render() {
    let scene = scene_with_emitting_sphere();
    let mut settings = Settings::default();
    settings.camera_paths.estimate_error = true;
    settings.camera_paths.groups_light = true;
    let integrator = Algorithm::Path.prepare(&scene, settings);
    let interrupted = AtomicBool::new(false);
    let stop = StopCriteria { max_passes: Some(6), ..StopCriteria::unlimited(&interrupted) };
    let start = || RenderResult::without_passes(integrator.as_ref(), (24, 16));
    let plain = render(start(), 0..u32::MAX, integrator.as_ref(), &stop, &SilentMonitor, |_| {});
    let page = LivePage::new("scene".to_owned(), "path", false, None);
    let mut live = RenderPublisher::begin(&page, Instant::now());
    live.publish_plan_and_limits(PlanReport::new(integrator.plan(), Vec::new()), &stop, (24, 16));
    let shown: RenderResult = render(start(), 0..u32::MAX, integrator.as_ref(), &stop, &SilentMonitor, |progress| {
        page.request_error_maps();
        live.publish_pass_if_due(progress, &stop);
    });
    live.publish_end(&shown, RenderStage::Ended);
    assert_eq!(plain.film, shown.film);
    let newest = page.newest_state();
    let (status, maps) = (&newest.state.status, newest.state.error_maps.as_ref().unwrap());
    assert_eq!((status.passes, status.stage), (6, RenderStage::Ended));
    assert_eq!(
        newest.state.picture.as_ref().unwrap().layer(LayerKind::Picture).unwrap().colors(),
        shown.film.mean_picture()
    );
    let direct = newest.state.picture.as_ref().unwrap().layer(LayerKind::Direct).unwrap();
    assert_eq!(direct.colors(), shown.light_group_films[LightGroup::Direct as usize].mean_picture());
    let estimator = shown.estimator.as_ref().unwrap();
    assert_eq!(maps.layer(LayerKind::Noise).unwrap().colors(), estimator.error_maps(&shown.film).noise);
    let estimate = estimator.estimate(&shown.film);
    let last = status.error_curve.last().unwrap();
    assert_eq!((last.passes, last.error, last.high), (6, estimate.error, estimate.high));
    assert_eq!(status.error_curve.iter().map(|point| point.passes).collect::<Vec<_>>(), [4, 5, 6]);
    let forecast = status.forecast.as_ref().unwrap();
    assert!(
        forecast.error_curve[0] == (6, estimate.error)
            || (forecast.error_curve[0].1 / estimate.error - 1.0).abs() < 1e-6
    );
    assert!(!forecast.is_render_target && forecast.target_error == 0.5 * estimate.error);
}

#[test]
fn many_readers_share_one_encoding() {
    let served = ServedPage::start();
    let number = served.page.begin_render();
    served.show(number, (300, 300), 1.0);
    let good = AtomicU32::new(0);
    std::thread::scope(|scope| {
        for _ in 0..16 {
            scope.spawn(|| {
                let answer = served.get("layer/picture");
                let is_whole = answer.code == 200 && answer.body.len() == frame::HEADER_BYTES + 2 * 3 * 300 * 300;
                good.fetch_add(u32::from(is_whole), Ordering::Relaxed);
            });
        }
    });
    assert_eq!(good.into_inner(), 16);
    let newest = served.page.newest_state();
    let frame = newest.state.picture.as_ref().unwrap();
    let [a, b] = [0, 1].map(|_| frame.encoded_layer(LayerKind::Picture).unwrap().as_ptr());
    assert_eq!(a, b);
}
