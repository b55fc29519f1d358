// What the buttons do.
const state = byId('state');
const bar = byId('bar');
let running = false;

function showReady() {
  const trains = named('train').length > 0;
  const hasDrive = drive.text.trim() !== '';
  document.querySelectorAll('[data-command]').forEach((button) => {
    const any = trains || named('holdout').length > 0;
    const isInspect = button.dataset.command === 'inspect';
    const works = isInspect ? any : hasDrive && (button.dataset.command === 'compare' ? any : trains);
    button.disabled = running || !works;
  });
  byId('stop').disabled = !running;
}

/** The limit of a diagnosis in s; null without one. */
function limitOf(text) {
  const given = text.trim().replace(',', '.');
  if (!given) return null;
  if (!(Number(given) > 0)) throw new Error(`time limit: "${text}"; expected a number of seconds above 0`);
  return Number(given);
}

async function run(command) {
  refuse();
  let asked;
  try {
    asked = request({ as_recorded: byId('as-recorded').checked, limit_s: limitOf(byId('limit').value) });
  } catch (error) {
    return refuse(error.message);
  }
  const of = drive.name;
  const made = inputsOf(command);
  running = true;
  showReady();
  const began = performance.now();
  const seconds = () => ((performance.now() - began) / 1000).toFixed(1);
  let share = '';
  const tell = () => { state.textContent = `${command}: ${seconds()} s${share}`; };
  tell();
  const clock = setInterval(tell, 200);
  bar.removeAttribute('value');
  bar.hidden = false;
  const progress = ({ done, of }) => {
    bar.value = Math.min(1, done / of);
    share = `, ${Math.round(100 * bar.value)} %`;
  };
  try {
    const found = JSON.parse(await engine.call(command, [asked], progress));
    state.textContent = `${command}: done in ${seconds()} s`;
    keep(command, { ...found, of, made });
  } catch (error) {
    const wasStopped = error instanceof Stopped;
    state.textContent = wasStopped ? `${command}: stopped after ${seconds()} s` : `${command}: not done`;
    if (!wasStopped) refuse(error.message);
  } finally {
    clearInterval(clock);
    bar.hidden = true;
    running = false;
    showReady();
  }
}

async function begin() {
  listenForFiles();
  listenForMachine();
  listenForMapping();
  listenForResults();
  listeners.push(showReady);
  byId('commands').onclick = ({ target }) => target.dataset.command && run(target.dataset.command);
  byId('stop').onclick = () => engine.stop();
  try {
    await engine.start();
    showForm();
    state.textContent = 'Ready.';
  } catch (error) {
    state.textContent = `This browser cannot run the studio: ${error.message}. Expected one of 2023 or later, such as Chromium, Firefox or Safari.`;
  }
  changed();
}

begin();
