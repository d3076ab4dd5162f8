//! Pictures that `render --tev` sends to a viewer. A test listener checks every byte.

use super::CliSandbox;
use std::collections::BTreeMap;
use std::io::Read;
use std::net::{TcpListener, TcpStream};
use std::thread;
use std::time::{Duration, Instant};

/// Image that a viewer holds: width, height, and the pixels of each channel.
#[derive(Debug, Default, PartialEq)]
struct ViewedImage {
    size: (u32, u32),
    channels: BTreeMap<String, Vec<f32>>,
}

/// Reader of the parts of a packet.
struct PacketReader<'a>(&'a [u8]);

impl PacketReader<'_> {
    fn bytes<const N: usize>(&mut self) -> [u8; N] {
        let (head, rest) = self.0.split_first_chunk().expect("the packet is too short");
        self.0 = rest;
        *head
    }

    fn number(&mut self) -> u32 {
        u32::from_le_bytes(self.bytes())
    }

    fn text(&mut self) -> String {
        let end = self.0.iter().position(|byte| *byte == 0).expect("a text ends with 0");
        let text = String::from_utf8(self.0[..end].to_vec()).unwrap();
        self.0 = &self.0[end + 1..];
        text
    }

    fn texts(&mut self, count: u32) -> Vec<String> {
        (0..count).map(|_| self.text()).collect()
    }
}

/// Accepts one connection and applies its packets. Returns the images by name, and the number of
/// packets of each kind.
fn view(listener: &TcpListener) -> (BTreeMap<String, ViewedImage>, BTreeMap<u8, usize>) {
    let (mut stream, _) = listener.accept().unwrap();
    let (mut images, mut kinds) = (BTreeMap::<String, ViewedImage>::new(), BTreeMap::new());
    let mut length = [0; 4];
    while stream.read_exact(&mut length).is_ok() {
        let mut packet = vec![0; u32::from_le_bytes(length) as usize - 4];
        stream.read_exact(&mut packet).unwrap();
        let mut packet = PacketReader(&packet);
        let ([kind, grabs_focus], name) = (packet.bytes(), packet.text());
        *kinds.entry(kind).or_default() += 1;
        match kind {
            4 => {
                let (size, count) = ((packet.number(), packet.number()), packet.number());
                let pixels = size.0 as usize * size.1 as usize;
                let channels = packet.texts(count).into_iter().map(|name| (name, vec![f32::NAN; pixels])).collect();
                assert_eq!(grabs_focus, 1);
                images.insert(name, ViewedImage { size, channels });
            }
            6 => {
                let image = images.get_mut(&name).expect("the image was created");
                let count = packet.number();
                let names = packet.texts(count);
                let [x, y, width, height] = std::array::from_fn(|_| packet.number() as usize);
                let numbers = |packet: &mut PacketReader<'_>| -> Vec<usize> {
                    (0..count).map(|_| u64::from_le_bytes(packet.bytes()) as usize).collect()
                };
                let (offsets, strides) = (numbers(&mut packet), numbers(&mut packet));
                let values: Vec<f32> = packet.0.as_chunks().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
                assert_eq!(packet.0.len(), 4 * values.len());
                for ((name, offset), stride) in names.iter().zip(offsets).zip(strides) {
                    let channel = image.channels.get_mut(name).expect("the channel was created");
                    for i in 0..width * height {
                        let pixel = (y + i / width) * image.size.0 as usize + x + i % width;
                        channel[pixel] = values[offset + i * stride];
                    }
                }
                packet.0 = &[];
                assert_eq!(grabs_focus, 0);
            }
            _ => panic!("a packet of kind {kind}"),
        }
        assert!(packet.0.is_empty(), "bytes are left in a packet of kind {kind}");
    }
    (images, kinds)
}

#[test]
fn viewers_receive_the_growing_picture_and_the_layers() {
    let sandbox = CliSandbox::new();
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let viewer = thread::spawn(move || view(&listener));
    let line = format!(
        "-o a.exr --size 300x250 --integrator path --spp 1 --passes 2 --light-groups --aov layers.exr \
         --no-error-estimate --tev {address}"
    );
    sandbox.render("box.txt", &line).expect(0, &[]);
    let (images, kinds) = viewer.join().unwrap();
    assert_eq!(kinds[&4], 2, "each image is created once");
    assert!(kinds[&6] > 4, "the picture and the layers come in bands: {kinds:?}");
    assert_eq!(images.keys().collect::<Vec<_>>(), ["box.txt", "box.txt layers"]);
    for (image, file, count) in [("box.txt", "a.exr", 12), ("box.txt layers", "layers.exr", 26)] {
        let image = &images[image];
        assert_eq!((image.size, image.channels.len()), ((300, 250), count), "{file}");
        let written = exr::prelude::read_first_flat_layer_from_file(sandbox.path(file)).unwrap().layer_data;
        for channel in &written.channel_data.list {
            let values: Vec<u32> = channel.sample_data.values_as_f32().map(f32::to_bits).collect();
            let sent: Vec<u32> = image.channels[&channel.name.to_string()].iter().map(|v| v.to_bits()).collect();
            assert!(values == sent, "{file}: channel {}", channel.name);
        }
    }
}

#[test]
fn refused_connections_give_one_warning() {
    let sandbox = CliSandbox::new();
    let address = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let run = sandbox.render("box.txt", &format!("-o a.exr --passes 6 --photons 1k --tev {address}"));
    run.expect(0, &["warning: the picture is not sent to 127.0.0.1"]);
    assert_eq!(run.stderr.matches("is not sent").count(), 1, "{}", run.stderr);
    sandbox.render("box.txt", "-o a.exr --tev here:now").expect(2, &["is no address"]);
}

/// The picture is larger than the send buffer of a connection, so writing blocks.
#[test]
#[ignore = "long: many runs of the program"]
fn a_stalled_viewer_does_not_delay_the_render() {
    let sandbox = CliSandbox::new();
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let held = thread::spawn(move || -> TcpStream { listener.accept().unwrap().0 });
    let start = Instant::now();
    let line = format!("-o a.exr --size 1600x1200 --integrator raycast --tev {address}");
    sandbox.render("box.txt", &line).expect(0, &["warning: tev"]);
    assert!(start.elapsed() < Duration::from_secs(60));
    drop(held.join().unwrap());
}
