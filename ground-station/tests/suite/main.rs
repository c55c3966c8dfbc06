//! Tests of the whole station: the command `uchain-ground` beside a simulated chain, with clients
//! of its page. None of them measures a time; they wait for what must come.

mod abuse;
mod access;
mod browser;
mod exported;
mod fleet;
mod foxglove;
mod in_chromium;
mod last_word;
mod last_word_in_chromium;
mod local_station;
mod losses;
mod map;
mod mission;
mod page_client;
mod recording;
mod resilient_page;
mod ros2;
mod severed_line;
mod simulated_chain;
mod stale_line_in_chromium;
mod stalling_proxy;
mod stalls;
mod station_process;
mod steps;
mod suspended;
mod through_bridge;
mod virtual_chain;
mod wide_in_chromium;
