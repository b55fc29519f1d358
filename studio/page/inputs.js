// What the commands work on: the drive, the recordings with their roles, and the columns mapped by hand.

const drive = { name: 'machine.toml', text: '' };
/** Role, size, fault and version of each recording, by name. */
const recordings = new Map();
/** Columns mapped by hand, and those left unused, before there is a machine file to write them to. */
const maps = new Map();
const unused = new Set();

/** Called whenever files, roles or the machine have changed. */
const listeners = [];
const changed = () => listeners.forEach((listener) => listener());

const named = (role) => [...recordings].filter(([, one]) => one.role === role).map(([name]) => name).sort();
const mapped = () => [...maps].map(([signal, header]) => `${signal}=${header}`);

/** Date, time and zone: 2026-05-06 07:08 +02:00. */
function now() {
  const two = (number) => String(Math.trunc(Math.abs(number))).padStart(2, '0');
  const at = new Date(), ahead = -at.getTimezoneOffset();
  const day = `${at.getFullYear()}-${two(at.getMonth() + 1)}-${two(at.getDate())}`;
  return `${day} ${two(at.getHours())}:${two(at.getMinutes())} ${ahead < 0 ? '-' : '+'}${two(ahead / 60)}:${two(ahead % 60)}`;
}

/** What every command works on. */
function inputs() {
  const machine = drive.text.trim() ? { ...drive } : null;
  return { machine, train: named('train'), holdout: named('holdout'), maps: mapped(), unused: [...unused] };
}

/** What every command is asked with. */
const request = (more = {}) => JSON.stringify({ ...inputs(), made: now(), ...more });

/** What the result of a command depends on, as a text: a result of another text is older than its inputs. */
function inputsOf(command) {
  const of = inputs();
  const [train, holdout] = [of.train, of.holdout].map((names) => names.map((name) => [name, recordings.get(name).version]));
  const options = { asRecorded: byId('as-recorded').checked, limit: byId('limit').value.trim() };
  if (command === 'inspect' || command === 'compare') return JSON.stringify({ ...of, train: [...train, ...holdout], holdout: [] });
  if (command === 'fit') delete options.limit;
  return JSON.stringify({ ...of, train, holdout, options });
}
