// The results of the commands, each under its name until it is run again, and marked where its inputs have changed since.
const results = new Map();
let shown;

/** Keeps the results of a command and shows them. */
function keep(command, found) {
  results.delete(command);
  results.set(command, found);
  show(command);
}

function show(command) {
  shown = command;
  const tab = (name) => {
    const button = element('button', { type: 'button', role: 'tab', onclick: () => show(name) });
    button.dataset.result = name;
    button.setAttribute('aria-selected', String(name === shown));
    return button;
  };
  byId('tabs').replaceChildren(...[...results.keys()].map(tab));
  byId('result').replaceChildren(...view(command, results.get(command)));
  byId('results').hidden = false;
  markOlder();
}

/** Marks the results that are older than the recordings, the mapping, the machine file or the options that they were made of. */
function markOlder() {
  const isOlder = (name) => results.get(name).made !== inputsOf(name);
  byId('tabs').querySelectorAll('[data-result]').forEach((tab) => {
    const name = tab.dataset.result;
    tab.textContent = isOlder(name) ? `${name} (older)` : name;
  });
  byId('older').hidden = !results.has(shown) || !isOlder(shown);
}

function listenForResults() {
  byId('as-recorded').onchange = markOlder;
  byId('limit').oninput = markOlder;
  listeners.push(markOlder);
}

function view(command, found) {
  const file = (text, name, type, what) => text && element('button', {
    type: 'button', textContent: `Save ${what}`, onclick: () => save(name, type, text),
  });
  const use = () => { Object.assign(drive, { name: found.of, text: found.machine }); check(); };
  const buttons = [
    file(found.page, `${command}.html`, 'text/html', 'the page'),
    file(found.json, `${command}.json`, 'application/json', 'JSON'),
    file(found.machine, `${command}.toml`, 'application/toml', 'the machine file'),
    found.machine && element('button', { type: 'button', textContent: 'Go on with this machine file', onclick: use }),
  ];
  const notes = found.notes.map((note) => element('p', { className: 'soft', textContent: `note: ${note}` }));
  const text = found.text && element('pre', { textContent: found.text });
  // The page of a command, in a frame of its own: it may run its charts and nothing else.
  const page = found.page && element('iframe', { title: `${command}: page`, srcdoc: found.page });
  page?.setAttribute('sandbox', 'allow-scripts');
  return [element('p', { className: 'buttons' }, ...buttons), ...notes, page, text].filter(Boolean);
}
