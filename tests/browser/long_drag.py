#!/usr/bin/python3
"""long_drag.py COMMAND SCENES MINUTES: drags on the live page without a pause; memory and delay minute by minute."""

import statistics
import sys
import time

from browser import Browser
from dragging import begin_drags, drags_since, server_memory
from live_server import LiveServer

command, scenes, minutes = sys.argv[1:]
with LiveServer(command, f"{scenes}/brace.toml") as live, Browser(1200, 800) as browser:
    browser.open(live.address)
    browser.wait("return window.live && !live.pending && live.shown === live.asked")
    browser.command("Performance.enable")
    begin_drags(browser, 60 * float(minutes) + 10, 1)
    total = 0
    for minute in range(round(float(minutes))):
        time.sleep(60)
        times, told, memory = drags_since(browser)
        assert not told, told
        total += len(times)
        print(f"minute {minute + 1}: {len(times)} drags, median {statistics.median(times):.1f} ms, 99 of 100 within {sorted(times)[len(times) * 99 // 100]:.1f} ms; "
              f"server {server_memory(live)} KiB, page {memory} KiB", flush=True)
    print(f"{total} drags")
