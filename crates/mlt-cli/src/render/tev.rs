//! The image so far in the viewer tev.

use std::{
    io,
    net::{TcpStream, ToSocketAddrs},
    time::Duration,
};

use anyhow::Context;
use tev_client::{PacketCreateImage, PacketUpdateImage, TevClient};

use crate::image::Image;

/// Longest time that a viewer may take to answer or to read.
const PATIENCE: Duration = Duration::from_secs(5);
/// The image's channels.
const CHANNELS: [&str; 3] = ["R", "G", "B"];

/// An image in a viewer.
pub(super) struct Tev {
    client: TevClient,
    name: String,
}

impl Tev {
    /// Has the viewer at an address make a black image of this size.
    pub(super) fn open(address: &str, name: &str, [width, height]: [u32; 2]) -> anyhow::Result<Self> {
        let remedy = || format!("--preview: no viewer answers at {address}; start tev first, or name its address");
        let mut client = connect(address).map(TevClient::wrap).with_context(remedy)?;
        let image = PacketCreateImage { image_name: name, grab_focus: true, width, height, channel_names: &CHANNELS };
        client.send(image).with_context(remedy)?;
        Ok(Self { client, name: name.into() })
    }

    /// Replaces the pixels.
    pub(super) fn show(&mut self, image: &Image) -> anyhow::Result<()> {
        let update = PacketUpdateImage {
            image_name: &self.name,
            grab_focus: false,
            channel_names: &CHANNELS,
            channel_offsets: &[0, 1, 2],
            channel_strides: &[3; 3],
            x: 0,
            y: 0,
            width: image.width as u32,
            height: image.height as u32,
            data: image.rgb.as_flattened(),
        };
        self.client.send(update).context("the viewer takes no more previews")
    }
}

fn connect(address: &str) -> io::Result<TcpStream> {
    let mut last = io::Error::from(io::ErrorKind::AddrNotAvailable);
    for place in address.to_socket_addrs()? {
        match TcpStream::connect_timeout(&place, PATIENCE) {
            Ok(stream) => {
                stream.set_write_timeout(Some(PATIENCE))?;
                return Ok(stream);
            }
            Err(error) => last = error,
        }
    }
    Err(last)
}
