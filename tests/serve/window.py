"""Clicks through cfclient's window: `window.py PART COUNT FOLDER`.

An unmodified cfclient is started in this process, and a script inside of it presses its buttons as
a hand would. It connects to the last of the COUNT drones that its scan finds, the base. Then, by
PART, it

    look    shows every tab, presses what a drone of the chain does not do, takes off, lands, and stops
    hover   flies the head with the assist mode Hover, by a gamepad

It needs a display, such as Xvfb's. `tests/suite/window.rs` runs it against `uchain serve`; FOLDER
gets the pictures, and cfclient's settings, so that those of a user are left alone.

Nothing is timed: every wait is for something to happen, and one generous limit ends the whole. A
traceback that cfclient prints, and a message box that it opens, are failures.
"""
import faulthandler
import json
import os
import sys
import traceback

PART, COUNT, FOLDER = sys.argv[1], int(sys.argv[2]), sys.argv[3]
LIMIT_S = 300
LEADING, LANDED = 3, 8  # node0.state
sys.argv[1:] = []  # cfclient reads the rest.
settings = os.path.join(FOLDER, "settings")
os.environ["XDG_CONFIG_HOME"] = settings
os.makedirs(os.path.join(settings, "cfclient"), exist_ok=True)
# A gamepad that another program moves comes with cfclient. With a gamepad it takes no commands.
with open(os.path.join(settings, "cfclient", "config.json"), "w") as file:
    json.dump({"window_size": [1380, 860], "enable_zmq_input": PART == "hover"}, file)

from PyQt6 import QtCore, QtTest, QtWidgets  # noqa: E402

problems = []


def note(kind, error, trace):
    problems.append("".join(traceback.format_exception(kind, error, trace)))


def wait_for(condition, what):
    """Until `condition` holds; a problem of cfclient's own ends the wait."""
    print(f"waits for {what}", file=sys.stderr)
    while not condition():
        QtTest.QTest.qWait(20)
        for box in QtWidgets.QApplication.topLevelWidgets():
            if isinstance(box, QtWidgets.QMessageBox) and box.isVisible():
                problems.append(f"{box.windowTitle()}: {box.text()}")
        assert not problems, problems
    assert not problems, problems


def click(button):
    assert button.isEnabled(), f"{button.text()} is greyed out: {button.toolTip()}"
    QtTest.QTest.mouseClick(button, QtCore.Qt.MouseButton.LeftButton)


class Hand:
    """What a user does, in order."""

    def __init__(self, window):
        self.window = window
        self.tabs = window.loaded_tab_toolboxes

    def values(self, group, name):
        return self.window.cf.param.values.get(group, {}).get(name)

    def picture(self, name):
        assert self.window.grab().save(os.path.join(FOLDER, name)), name

    def connect(self):
        window = self.window
        wait_for(window.scanButton.isEnabled, "the first scan")
        click(window.scanButton)
        combo = window.interfaceCombo
        wait_for(lambda: combo.count() == COUNT + 1 and window.scanButton.isEnabled(),
                 f"{COUNT} drones in the scan")
        combo.setCurrentIndex(COUNT)
        click(window.connectButton)
        wait_for(lambda: window.connectButton.text() == "Disconnect", "the connection")
        wait_for(lambda: window.cf.param.is_updated, "all parameters")

    def look_at_every_tab(self):
        """Each tab is opened, shown, and drawn."""
        for action in self.window.tabs_menu_item.actions():
            if not action.isChecked():
                action.trigger()
        shown = self.window.tab_widget
        for index in range(shown.count()):
            shown.setCurrentIndex(index)
            QtTest.QTest.qWaitForWindowExposed(self.window)
            QtTest.QTest.qWait(50)
            assert not problems, (shown.tabText(index), problems)
        print(f"{shown.count()} tabs", file=sys.stderr)

    def press_what_does_nothing(self):
        """Buttons and sliders for what a drone of the chain does not have."""
        console = self.tabs["Console"]
        self.window.tab_widget.setCurrentWidget(console)
        for button in (console._dumpSystemLoadButton, console._propellerTestButton,
                       console._batteryTestButton, console._storageStatsButton,
                       console._dumpAssertInformation):
            click(button)
        wait_for(lambda: "Refused" in console.console.toPlainText(), "the console to refuse")
        tuning = self.tabs["Tuning"]
        self.window.tab_widget.setCurrentWidget(tuning)
        # The tab asks for no values, and misses those that come before it listens.
        click(tuning.default_values_button)
        for name, mapper in tuning.mappers.items():
            gain = float(self.values(*name.split(".")))
            assert mapper.slider.value == gain, (name, mapper.slider.value, gain)
        slider = tuning.mappers["pid_rate.roll_kp"].slider
        gain = slider.value
        slider.input.stepUp()
        assert slider.value != gain
        # A slider follows the drone's answers only when it was not moved for a moment.
        QtTest.QTest.qWait(500)
        click(tuning.default_values_button)
        assert slider.value == gain, (slider.value, gain)

    def task(self):
        return self.values("uchain", "task")

    def ask_task(self):
        """The order that the base gives now."""
        self.window.cf.param.request_param_update("uchain.task")
        QtTest.QTest.qWait(100)
        return self.task()

    def hover(self):
        """The head flies as fast as the stick says while the gamepad's button is held."""
        import zmq
        stick = zmq.Context().socket(zmq.PUSH)
        stick.connect("tcp://127.0.0.1:1212")
        flight = self.tabs["Flight Control"]
        self.window.tab_widget.setCurrentWidget(flight)
        self.is_on_hover()
        seen = {}
        watch = self.watch(seen)
        stick.send_json({"ctrl": {"assistedControl": True, "pitch": 0.3, "thrust": 32767}})
        wait_for(lambda: seen.get("node0.forward", 0) > 0.2, "the head to fly")
        wait_for(lambda: flight.targetPitch.text() == "0.30 m/s", "the window to show the speed")
        self.picture("hover.png")
        stick.send_json({"ctrl": {"pitch": 0.0}})
        wait_for(lambda: abs(seen.get("node0.forward", 1)) < 0.05, "the head to stop")
        stick.send_json({"ctrl": {"assistedControl": False}})
        # The newest order counts, and while the button is held there is always a newer one.
        wait_for(lambda: not flight.targetHeight.isEnabled(), "the end of the set-points")
        self.window.cf.param.set_value("uchain.task", 2)
        wait_for(lambda: seen.get("node0.state") == LANDED, "the head to be home")
        watch.stop()
        watch.delete()

    def is_on_hover(self):
        modes = self.tabs["Flight Control"]._assist_mode_combo
        wait_for(lambda: modes.currentText() == "Hover", "the assist mode Hover")
        assert modes.model().item(modes.currentIndex()).isEnabled(), "Hover is greyed out"

    def fly(self):
        """Take-off and landing by the buttons of the Flight Control tab."""
        flight = self.tabs["Flight Control"]
        self.window.tab_widget.setCurrentWidget(flight)
        wait_for(flight.commanderBox.isEnabled, "the commands of the Flight Control tab")
        assert flight.armButton.text() == "Auto armed", flight.armButton.text()
        self.is_on_hover()
        click(flight.commanderTakeOffButton)
        wait_for(lambda: self.ask_task() == "1", "the order to explore")
        seen = {}
        watch = self.watch(seen)
        wait_for(lambda: seen.get("node0.state") == LEADING, "the head to lead")
        self.picture("flight.png")
        click(flight.commanderLandButton)
        wait_for(lambda: self.ask_task() == "3", "the order to land")
        wait_for(lambda: seen.get("node0.state") == LANDED, "the head to have landed")
        watch.stop()
        watch.delete()

    def stop(self):
        """The red button, which is the last order that a base takes."""
        click(self.window.esButton)
        wait_for(lambda: self.ask_task() == "4", "the emergency stop")

    def watch(self, seen):
        """Logs the head's state, as the Plotter would."""
        from cflib.crazyflie.log import LogConfig
        config = LogConfig("head", period_in_ms=100)
        config.add_variable("node0.state", "uint8_t")
        config.add_variable("node0.forward", "float")
        self.window.cf.log.add_config(config)
        config.data_received_cb.add_callback(lambda _, row, __: seen.update(row))
        config.start()
        return config

    def leave(self):
        click(self.window.connectButton)
        wait_for(lambda: self.window.connectButton.text() == "Connect", "the end of the connection")


def drive():
    try:
        [window] = [widget for widget in QtWidgets.QApplication.topLevelWidgets()
                    if type(widget).__name__ == "MainUI"]
        hand = Hand(window)
        hand.connect()
        if PART == "hover":
            hand.hover()
        else:
            hand.look_at_every_tab()
            hand.press_what_does_nothing()
            hand.fly()
            hand.stop()
        hand.leave()
        assert not problems, problems
    except BaseException:
        traceback.print_exc()
        sys.stderr.flush()
        os._exit(1)
    print("cfclient was clicked through", file=sys.stderr)
    os._exit(0)


class Application(QtWidgets.QApplication):
    """The application that cfclient makes, with `drive` as its first event."""

    def exec(self=None):
        sys.excepthook = note
        QtCore.QTimer.singleShot(0, drive)
        return QtWidgets.QApplication.instance().__class__.__base__.exec()


faulthandler.dump_traceback_later(LIMIT_S, exit=True)
QtWidgets.QApplication = Application
import cfclient.gui  # noqa: E402

cfclient.gui.main()
