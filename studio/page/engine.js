// The crates, in a worker of their own: the page stays alive, and whatever runs can be ended.

/** What a call that was stopped ends with. */
class Stopped extends Error {}

const engine = {
  /** What the worker was given, to be given again to the next one. */
  files: new Map(),
  questions: [],

  /** Begins a worker; calls wait until it has what the last one had. */
  start() {
    this.ready = this.begin();
    // Whoever calls is told.
    this.ready.catch(() => {});
    return this.ready;
  },

  async begin() {
    this.wasm ??= await unpacked(byId('wasm').textContent);
    this.source ??= URL.createObjectURL(new Blob([byId('worker').textContent], { type: 'text/javascript' }));
    this.worker = new Worker(this.source);
    this.open = new Map();
    this.last = 0;
    this.worker.onmessage = ({ data }) => this.answered(data);
    this.worker.onerror = (event) => {
      const reason = new Error(event.message || 'the worker cannot be started');
      // One that never answered would fail again.
      if (this.questions.length) this.restart(reason); else this.end(reason);
    };
    this.questions = JSON.parse(await this.post({ wasm: this.wasm }));
    for (const [name, bytes] of this.files) await this.post({ method: 'put', given: [name, bytes] });
  },

  post(message, progress) {
    const id = ++this.last;
    return new Promise((done, failed) => {
      this.open.set(id, { done, failed, progress });
      this.worker.postMessage({ id, ...message });
    });
  },

  /** The result of a method of the crates. */
  async call(method, given, progress) {
    const { ready } = this;
    await ready;
    // Ended before it began.
    if (ready !== this.ready) throw new Stopped('stopped');
    return this.post({ method, given }, progress);
  },

  /** A worker that is stopped meanwhile does not matter: the next one is given what `files` holds. */
  async put(name, bytes) {
    this.files.set(name, bytes);
    await unlessStopped(this.call('put', [name, bytes]));
  },

  async remove(name) {
    this.files.delete(name);
    await unlessStopped(this.call('remove', [name]));
  },

  answered({ id, progress, result, error, isFault }) {
    const call = this.open.get(id);
    if (!call) return;
    if (progress) return call.progress?.(progress);
    this.open.delete(id);
    if (error === undefined) return call.done(result);
    call.failed(new Error(isFault ? `The program failed: ${error}. Please report this with the file.` : error));
    if (isFault) this.restart(new Stopped('ended with a command that failed'));
  },

  /** Ends whatever runs. */
  stop() {
    return this.restart(new Stopped('stopped'));
  },

  end(reason) {
    this.worker.terminate();
    const open = [...this.open.values()];
    this.open.clear();
    open.forEach((call) => call.failed(reason));
  },

  restart(reason) {
    this.end(reason);
    return this.start();
  },
};

/** Waits for a call whose worker may be stopped. */
async function unlessStopped(call) {
  try {
    await call;
  } catch (error) {
    if (!(error instanceof Stopped)) throw error;
  }
}

/** Bytes from packed text. */
async function unpacked(text) {
  const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('gzip'));
  return new Response(stream).arrayBuffer();
}
