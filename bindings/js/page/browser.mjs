// SPDX-License-Identifier: MIT
// A headless Chromium that obeys over its pipe (the protocol of its developer tools), without packages.
import { spawn } from 'node:child_process';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

export class Browser {
  /** `messages` collects what pages write to the console, exceptions, and failed requests. */
  constructor(program = 'chromium') {
    this.profile = mkdtempSync(join(tmpdir(), 'selvedge_browser_'));
    this.process = spawn(program, ['--headless=new', '--no-sandbox', '--remote-debugging-pipe', '--enable-unsafe-swiftshader', '--use-angle=swiftshader',
      '--no-first-run', '--disable-extensions', '--disable-dev-shm-usage', `--user-data-dir=${this.profile}`, 'about:blank'],
    { stdio: ['ignore', 'ignore', 'ignore', 'pipe', 'pipe'] });
    Object.assign(this, { number: 0, waiting: new Map(), messages: [], rest: '' });
    this.process.stdio[4].on('data', (data) => this.read(data.toString()));
  }

  read(text) {
    const parts = (this.rest + text).split('\0');
    this.rest = parts.pop();
    for (const part of parts) this.take(JSON.parse(part));
  }

  take({ id, method, params, result, error }) {
    if (id !== undefined) {
      const { resolve, reject } = this.waiting.get(id);
      this.waiting.delete(id);
      if (error) reject(new Error(error.message));
      else resolve(result);
    } else if (method === 'Runtime.consoleAPICalled') {
      this.messages.push(params.args.map((a) => a.value ?? a.description).join(' '));
    } else if (method === 'Runtime.exceptionThrown') {
      this.messages.push(params.exceptionDetails.exception?.description ?? params.exceptionDetails.text);
    } else if (method === 'Log.entryAdded') {
      this.messages.push(params.entry.text);
    }
  }

  call(method, params = {}) {
    const id = ++this.number;
    this.process.stdio[3].write(`${JSON.stringify({ id, method, params, sessionId: this.session })}\0`);
    return new Promise((resolve, reject) => this.waiting.set(id, { resolve, reject }));
  }

  /** Opens an address in a window of this size. */
  async open(url, { width, height, mobile = false, scale = 1 }) {
    this.session = undefined;
    const { targetId } = await this.call('Target.createTarget', { url: 'about:blank' });
    this.session = (await this.call('Target.attachToTarget', { targetId, flatten: true })).sessionId;
    for (const domain of ['Page', 'Runtime', 'Log', 'DOM', 'Performance']) await this.call(`${domain}.enable`);
    await this.call('Emulation.setDeviceMetricsOverride', { width, height, mobile, deviceScaleFactor: scale });
    if (mobile) await this.call('Emulation.setTouchEmulationEnabled', { enabled: true });
    await this.call('Page.navigate', { url });
  }

  async evaluate(expression) {
    const { result, exceptionDetails } = await this.call('Runtime.evaluate', { expression, awaitPromise: true, returnByValue: true });
    if (exceptionDetails) throw new Error(exceptionDetails.exception?.description ?? exceptionDetails.text);
    return result.value;
  }

  /** Waits until an expression is true. */
  async until(expression, seconds = 300) {
    for (const end = Date.now() + 1000 * seconds; Date.now() < end; await new Promise((resolve) => setTimeout(resolve, 100)))
      if (await this.evaluate(`Boolean(document.documentElement && (${expression}))`)) return;
    throw new Error(`not within ${seconds} s: ${expression}; messages: ${this.messages.join('; ')}`);
  }

  async picture() {
    return Buffer.from((await this.call('Page.captureScreenshot', { format: 'png' })).data, 'base64');
  }

  async mouse(type, x, y) {
    await this.call('Input.dispatchMouseEvent', { type, x, y, button: 'left', buttons: type === 'mouseReleased' ? 0 : 1, clickCount: 1 });
  }

  /** Chooses files on disk for an input. */
  async choose(selector, ...files) {
    const { root } = await this.call('DOM.getDocument');
    const { nodeId } = await this.call('DOM.querySelector', { nodeId: root.nodeId, selector });
    await this.call('DOM.setFileInputFiles', { nodeId, files });
  }

  async close() {
    this.session = undefined;
    const ended = new Promise((resolve) => this.process.on('exit', resolve));
    await this.call('Browser.close');
    await ended;
    rmSync(this.profile, { recursive: true, force: true });
  }
}
