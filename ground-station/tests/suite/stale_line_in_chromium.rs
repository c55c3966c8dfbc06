//! What the page itself writes, and when it gives up a line, seen in a real browser behind a proxy that
//! stalls. The station refuses late orders, too: that they do not arrive says nothing about the page.

use std::path::PathBuf;

use crate::browser::Browser;
use crate::simulated_chain::SimulatedChain;
use crate::stalling_proxy::StallingProxy;
use crate::station_process::StationProcess;

/// Notes in the page what it writes to its lines, before the browser has it.
const NOTE: &str = "globalThis.wrote = []; \
                    globalThis.carry = WebSocket.prototype.send; \
                    WebSocket.prototype.send = function (text) { \
                        wrote.push(JSON.parse(text).do); carry.call(this, text); }; true";

/// The orders and requests of the pilot that the page has written.
const ORDERS: &str = "wrote.filter((what) => what === 'order' || what === 'survey').length";

/// A page behind a proxy, beside a chain and its station.
struct Behind {
    _chain: SimulatedChain,
    _station: StationProcess,
    proxy: StallingProxy,
    browser: Browser,
}

impl Behind {
    async fn open(test: &str) -> Self {
        let chain = SimulatedChain::demo();
        let station = StationProcess::start(&chain.address(), &[]);
        let proxy = StallingProxy::to(station.page);
        let profile = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(test);
        let _ = std::fs::remove_dir_all(&profile);
        std::fs::create_dir_all(&profile).unwrap();
        let mut browser = Browser::open(&profile, &format!("http://{}/", proxy.at)).await;
        browser.wait_for("typeof steers !== 'undefined' && steers").await;
        browser.evaluate(NOTE).await;
        Self { _chain: chain, _station: station, proxy, browser }
    }

    async fn orders(&mut self) -> u64 {
        self.browser.evaluate(ORDERS).await.as_u64().unwrap()
    }
}

#[tokio::test]
#[ignore = "needs chromium"]
async fn the_page_writes_no_order_to_a_stale_line_in_chromium() {
    let mut page = Behind::open("stale-line").await;
    page.browser.press("t").await;
    page.browser.wait_for(&format!("{ORDERS} === 1")).await;
    // The line stays open as long as this test looks at it.
    page.browser.evaluate("PATIENCE_MS.fill(600000); line.patience = 600000; true").await;
    page.proxy.freeze();
    page.browser.wait_for("line.age() > 600").await;
    for key in ["e", "t", "r", "l", "p", "w", "1", " "] {
        page.browser.press(key).await;
        let said = "at('warning').innerText.includes('nothing has come from the station for')";
        assert_eq!(page.browser.evaluate(said).await, true, "{key}");
        page.browser.evaluate("warn(''); true").await;
    }
    assert_eq!(page.orders().await, 1, "orders were written to a stale line");
    // A stop is written to any line.
    page.browser.press("Escape").await;
    page.browser.wait_for("wrote.includes('stop')").await;
    assert_eq!(page.browser.evaluate("line.isOpen()").await, true);
}

/// An act that waited in a busy page is no act of this moment.
#[tokio::test]
#[ignore = "needs chromium"]
async fn the_page_writes_no_order_that_waited_in_it_in_chromium() {
    let mut page = Behind::open("held-order").await;
    let give = |ago: u32| format!("order('explore', {{ speed: 0.2 }}, performance.now() - {ago})");
    // A state has come just now, so that only the act is old.
    let fresh = |give: String| format!("line.came = performance.now(); {give}");
    let held = page.browser.evaluate(&fresh(give(600))).await;
    assert_eq!(held, serde_json::Value::Null);
    assert_eq!(page.orders().await, 0);
    page.browser.wait_for("at('warning').innerText.includes('this page was busy for 0.6 s')").await;
    page.browser.evaluate(&fresh(give(0))).await;
    page.browser.wait_for(&format!("{ORDERS} === 1")).await;
}

/// A line that stalls ends by the page alone: what the proxy holds back tells neither side of an end.
#[tokio::test]
#[ignore = "needs chromium"]
async fn the_page_gives_up_a_line_that_stalls_in_chromium() {
    type Stall = fn(&StallingProxy);
    let stalls: [(&str, Stall); 2] =
        [("both ways", StallingProxy::freeze), ("upwards", StallingProxy::freeze_up)];
    for (way, stall) in stalls {
        let mut page = Behind::open("given-up").await;
        page.browser.evaluate("globalThis.first = line.socket; true").await;
        stall(&page.proxy);
        page.browser.wait_for("line.socket !== null && line.socket !== first").await;
        // The page has left it, and was not left by it: a line that has ended closes by itself.
        assert_eq!(page.browser.evaluate("first.onclose").await, serde_json::Value::Null, "{way}");
        page.proxy.flow();
        page.browser.wait_for("line.isOpen() && line.age() < 500 && steers").await;
    }
}
