//! The command `uchain-ground`.

use std::fmt;
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;

use crate::access::{Access, Refused};
use crate::address::Address;
use crate::check::check;
use crate::fleet::Fleet;
use crate::link::UdpLink;
use crate::map::MapArgs;
use crate::range_survey::sensitivity;
use crate::recorder::Recorder;
use crate::station::Setup;
use crate::{listener, server, station, token};

/// The port of the page.
const PORT: u16 = 8430;

/// The exit status for bad input.
const BAD_INPUT: u8 = 2;

/// Serves the operator's page for a chain of drones, and gives its orders to the base
#[derive(Debug, Parser)]
#[command(name = "uchain-ground", version, max_term_width = 100)]
struct Arguments {
    /// The base: udp://HOST:PORT, the last address that `uchain serve` prints, or, with the feature
    /// crazyradio, radio:// with number, channel, data rate and address of a real one
    #[arg(required_unless_present = "fleet")]
    base: Option<Address>,
    /// The fleet file (TOML, or crazyswarm2's crazyflies.yaml): it names the drones, and the base where
    /// no address is given
    #[arg(long, value_name = "FILE")]
    fleet: Option<PathBuf>,
    /// Check every drone of the fleet file against it, one after the other, and serve no page; the
    /// exit status is 1 where one is not as the file has it
    #[arg(long, requires = "fleet", conflicts_with = "base")]
    check: bool,
    /// Write the fleet as crazyswarm2's crazyflies.yaml into this file, which must not be there yet, and
    /// serve no page
    #[arg(long, value_name = "FILE", requires = "fleet", conflicts_with_all = ["base", "check"])]
    export: Option<PathBuf>,
    /// The port of the page; 0 for any that is free
    #[arg(long, default_value_t = PORT)]
    port: u16,
    /// The address at which the page is served; any but this machine's own needs a token
    #[arg(long, default_value_t = Ipv4Addr::LOCALHOST.into(), value_name = "ADDRESS")]
    host: IpAddr,
    /// The file with the token, 8 characters or more, that other machines must add to the page's
    /// address as ?token=TOKEN. The variable UCHAIN_TOKEN of the environment may have it, too
    #[arg(long, value_name = "FILE", group = "tokens")]
    token_file: Option<PathBuf>,
    /// Make a token for this run, and print it in the page's address
    #[arg(long, group = "tokens")]
    new_token: bool,
    /// The token itself; every user of this machine can read it in the list of processes
    #[arg(long, group = "tokens")]
    token: Option<String>,
    /// Records to packets.csv and station.mcap in this folder, which must not have them yet
    #[arg(long, value_name = "DIR")]
    record: Option<PathBuf>,
    #[command(flatten)]
    map: MapArgs,
    /// Publish what the page shows to ROS 2 as well, in this domain, where left out in that of
    /// ROS_DOMAIN_ID or 0. For `cargo ground-ros2`
    #[arg(long, value_name = "DOMAIN", num_args = 0..=1, require_equals = true, conflicts_with = "check")]
    ros2: Option<Option<String>>,
    /// Let every program in that domain steer, by /cmd_vel and /order: ROS 2 has no token
    #[arg(long, requires = "ros2")]
    ros2_steer: bool,
}

/// Why the station cannot run.
#[derive(Debug)]
struct Unusable {
    wrong: String,
    remedy: String,
}

impl fmt::Display for Unusable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}; {}", self.wrong, self.remedy)
    }
}

/// Runs the command.
#[must_use]
pub fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => {
            let _ = error.print();
            return ExitCode::from(if error.use_stderr() { BAD_INPUT } else { 0 });
        }
    };
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
    let done = match runtime {
        Ok(runtime) => runtime.block_on(begin(&arguments)),
        Err(error) => {
            eprintln!("uchain-ground: this machine starts no tasks: {error}");
            return ExitCode::FAILURE;
        }
    };
    match done {
        Ok(code) => code,
        Err(unusable) => {
            eprintln!("uchain-ground: {unusable}");
            ExitCode::from(BAD_INPUT)
        }
    }
}

/// Checks or exports the fleet, or runs the station, as the arguments say.
async fn begin(arguments: &Arguments) -> Result<ExitCode, Unusable> {
    let fleet = arguments.fleet.as_deref().map(Fleet::read).transpose().map_err(unusable)?;
    let fleet = fleet.unwrap_or_default();
    if let Some(file) = &arguments.export {
        fleet.export(file).map_err(unusable)?;
        println!("wrote {}", file.display());
        return Ok(ExitCode::SUCCESS);
    }
    if arguments.check {
        let wrong = check(&fleet, |lines| println!("{lines}")).await;
        let all = fleet.drones.len();
        println!("{wrong} of {all} drones are not as the fleet file has them");
        return Ok(if wrong == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE });
    }
    run(arguments, fleet).await.map(|()| ExitCode::SUCCESS)
}

async fn run(arguments: &Arguments, fleet: Fleet) -> Result<(), Unusable> {
    let address = arguments.base.as_ref().or_else(|| fleet.base().map(|base| &base.address));
    let address = address.ok_or_else(no_base)?;
    let sensitivity = Some(sensitivity(&address.to_string()));
    let way = address.open().map_err(unusable)?;
    let base = way.port;
    let plan = arguments.map.open().map_err(unusable)?;
    let token = find_token(arguments).map_err(unusable)?;
    let access = Access::new(arguments.host, token.clone()).map_err(no_access)?;
    let at = SocketAddr::from((arguments.host, arguments.port));
    let listener = listener::open(at).map_err(|error| Unusable {
        wrong: format!("the page cannot be served at {at} ({error})"),
        remedy: "end the other station, or give another --port".to_owned(),
    })?;
    let domain = arguments.ros2.as_ref().map(Option::as_deref);
    let node = domain.map(|domain| ros2_node::open(domain, arguments.ros2_steer)).transpose()?;
    let recorder = arguments.record.as_deref().map(Recorder::create).transpose();
    let recorder = recorder.map_err(|error| Unusable {
        wrong: format!("the recording cannot be created ({error})"),
        remedy: "give --record a folder that has no recording yet".to_owned(),
    })?;
    let link = UdpLink::open(base).await.map_err(|error| Unusable {
        wrong: format!("there is no way to {base} ({error})"),
        remedy: "check the base's address".to_owned(),
    })?;
    let page = listener.local_addr().unwrap_or(at);
    let token = shown(token, arguments);
    let station = station::start(link, Setup { recorder, plan, fleet, sensitivity });
    node.map(|node| node.start(station.clone())).transpose()?;
    println!("the page is at http://{page}/{token}; Ctrl-C ends the station");
    let app = server::router(access, station);
    tokio::select! {
        () = listener::serve(listener, app) => {}
        _ = tokio::signal::ctrl_c() => {}
    }
    Ok(())
}

/// The node of ROS 2 beside the station.
#[cfg(feature = "ros2")]
mod ros2_node {
    use ros2_topics::{Commands, Domain, Node};

    use super::{Unusable, unusable};
    use crate::station::Handle;

    pub(super) struct Opened(Node, Option<Commands>);

    /// Joins a domain, and follows its commands where programs may steer.
    pub(super) fn open(domain: Option<&str>, steers: bool) -> Result<Opened, Unusable> {
        let domain = Domain::of_option(domain).map_err(unusable)?;
        let mut node = Node::open(domain, "uchain_station").map_err(unusable)?;
        let commands = steers.then(|| node.follow()).transpose().map_err(unusable)?;
        Ok(Opened(node, commands))
    }

    impl Opened {
        pub(super) fn start(self, station: Handle) -> Result<(), Unusable> {
            let Self(node, commands) = self;
            crate::ros2::start(node, commands, station).map_err(|error| Unusable {
                wrong: format!("--ros2: the topics cannot be published: {error}"),
                remedy: "give another domain, or look whether the network is up".to_owned(),
            })
        }
    }
}

/// The stand-in in a build without it.
#[cfg(not(feature = "ros2"))]
mod ros2_node {
    use super::Unusable;
    use crate::station::Handle;

    pub(super) enum Opened {}

    pub(super) fn open(_: Option<&str>, _: bool) -> Result<Opened, Unusable> {
        Err(Unusable {
            wrong: "--ros2: this uchain-ground was built without ROS 2".to_owned(),
            remedy: "start it by `cargo ground-ros2` in place of `cargo run`".to_owned(),
        })
    }

    impl Opened {
        pub(super) fn start(self, _: Handle) -> Result<(), Unusable> {
            match self {}
        }
    }
}

/// What the printed address of the page says of the token.
fn shown(token: Option<String>, arguments: &Arguments) -> String {
    match token {
        Some(token) if arguments.new_token => format!("?token={token}"),
        Some(_) => "?token=TOKEN".to_owned(),
        None => String::new(),
    }
}

/// The token, from where the operator has put it.
fn find_token(arguments: &Arguments) -> Result<Option<String>, token::Unusable> {
    if let Some(token) = &arguments.token {
        eprintln!(
            "uchain-ground: every user of this machine can read a token given by --token in the \
             list of processes; put it into a file of yours and give --token-file"
        );
        return token::check(token).map(Some);
    }
    if let Some(file) = &arguments.token_file {
        return token::read(file).map(Some);
    }
    if arguments.new_token {
        return token::make().map(Some);
    }
    let variable = std::env::var(token::VARIABLE).ok().filter(|token| !token.is_empty());
    let checked = variable.as_deref().map(token::check).transpose();
    checked.map_err(|why| format!("{}: {why}", token::VARIABLE))
}

fn no_base() -> Unusable {
    Unusable { wrong: "no base was given".to_owned(), remedy: "give its address".to_owned() }
}

fn unusable(error: impl ToString) -> Unusable {
    let error = error.to_string();
    let (wrong, remedy) = error.split_once("; ").unwrap_or((&error, "check what was given"));
    Unusable { wrong: wrong.to_owned(), remedy: remedy.to_owned() }
}

fn no_access(refused: Refused) -> Unusable {
    match refused {
        Refused::Token => Unusable {
            wrong: "other machines can reach this address".to_owned(),
            remedy: "add --new-token or --token-file (rather than --token), or leave --host out"
                .to_owned(),
        },
        _ => Unusable {
            wrong: "this machine gives no random numbers for a session".to_owned(),
            remedy: "start the station on another machine".to_owned(),
        },
    }
}
