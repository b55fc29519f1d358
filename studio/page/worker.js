// The worker: holds the files and runs one command at a time. Stopping it ends it.
let studio;
const LEAST_MS_BETWEEN = 50;

self.onmessage = ({ data: { id, wasm, method, given } }) => {
  try {
    if (wasm) {
      hostSim.initSync({ module: wasm });
      studio = new hostSim.Studio();
      self.postMessage({ id, result: studio.questions() });
      return;
    }
    let told = 0;
    const progress = (done, of) => {
      const now = Date.now();
      if (now - told < LEAST_MS_BETWEEN && done < of) return;
      told = now;
      self.postMessage({ id, progress: { done, of } });
    };
    self.postMessage({ id, result: studio[method](...given, progress) });
  } catch (error) {
    // A text is an answer of the crates; anything else a fault of theirs, after which they cannot go on.
    const isAnswer = typeof error === 'string';
    self.postMessage({ id, error: isAnswer ? error : String(error.message ?? error), isFault: !isAnswer });
  }
};
