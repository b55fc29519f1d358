// The files that are dropped: recordings with their roles, and at most one machine file.
const ROLES = { train: 'train', holdout: 'hold out', unused: 'leave out' };

/** How many recordings were taken in: each has the number of its own, so that another file of the same name is another one. */
let versions = 0;

/** Takes files in; what cannot be read is said beside it. */
async function take(files) {
  refuse();
  const problems = [];
  const taken = new Map();
  for (const file of files) {
    const path = file.webkitRelativePath || file.name;
    const isMachine = /\.toml$/i.test(file.name);
    const slot = isMachine ? '.toml' : file.name;
    if (taken.has(slot)) {
      problems.push(`${path}: left out beside ${taken.get(slot)}; expected ${isMachine ? 'one machine file' : 'recordings of different names'}`);
      continue;
    }
    taken.set(slot, path);
    try {
      if (isMachine) {
        // As the text field below holds it.
        Object.assign(drive, { name: file.name, text: (await file.text()).replace(/\r\n?/g, '\n') });
      } else {
        const bytes = new Uint8Array(await file.arrayBuffer());
        await engine.put(file.name, bytes);
        const role = /^holdout-/i.test(file.name) ? 'holdout' : 'train';
        recordings.set(file.name, { size: file.size, role: recordings.get(file.name)?.role ?? role, version: ++versions });
      }
    } catch (error) {
      problems.push(`${file.name}: cannot be read: ${error.message}`);
    }
  }
  await check();
  if (problems.length) refuse(problems.join('\n'));
}

/** Looks at every recording, so that a fault is shown before work begins. */
async function check() {
  for (const [name, one] of recordings) {
    const { error } = await surveyed(name);
    one.fault = error;
  }
  changed();
}

/** The columns of one recording, or why there are none. */
async function surveyed(name) {
  const asked = JSON.stringify({ ...JSON.parse(request()), train: [name], holdout: [] });
  try {
    return JSON.parse(await engine.call('columns', [asked])).files[0];
  } catch (error) {
    // It waited for a command that was stopped.
    if (error instanceof Stopped) return surveyed(name);
    return { file: name, columns: [], error: error.message };
  }
}

/** The files of a drop, those of folders too. Browsers read no entries of a page that is a file itself, but handles and files. */
async function dropped(transfer) {
  const items = [...transfer.items].filter((item) => item.kind === 'file');
  const isFolder = (item) => item.webkitGetAsEntry?.()?.isDirectory;
  // Both are gone once the event is over.
  const files = items.filter((item) => !isFolder(item)).map((item) => item.getAsFile());
  const folders = items.filter(isFolder).map((item) => item.getAsFileSystemHandle?.());
  for (const folder of await Promise.all(folders)) {
    if (!folder) throw new Error('this browser reads no dropped folder; expected files, or the folder by "choose a folder"');
    for await (const inner of folder.values()) if (inner.kind === 'file' && isOfDrive(inner.name)) files.push(await inner.getFile());
  }
  return files;
}

/** Whether a file of a folder is one of a drive's: not what lies beside them. */
const isOfDrive = (name) => !/^\.|\.(md|html?|json|svg|png|pdf)$/i.test(name);

function showFiles() {
  const rows = [...recordings].map(([name, one]) => {
    const options = Object.entries(ROLES).map(([value, text]) => element('option', { value, textContent: text, selected: value === one.role }));
    const role = element('select', { ariaLabel: `role of ${name}`, onchange: () => { one.role = role.value; changed(); } }, ...options);
    const forget = () => { recordings.delete(name); changed(); return engine.remove(name); };
    const fault = one.fault && element('div', { className: 'problem', textContent: one.fault });
    return element('tr', {},
      element('td', {}, name, fault),
      element('td', { className: 'number', textContent: `${Math.max(1, Math.round(one.size / 1024))} KB` }),
      element('td', {}, role),
      element('td', {}, element('button', { type: 'button', className: 'plain', textContent: '✕', title: `forget ${name}`, onclick: forget })));
  });
  byId('list').replaceChildren(...(rows.length ? [table(['recording', 'size', 'use', ''], rows)] : []));
}

function listenForFiles() {
  const zone = byId('drop');
  const over = (is) => (event) => { event.preventDefault(); zone.classList.toggle('over', is); };
  // Anywhere: a file that misses the zone would replace the page.
  document.addEventListener('dragover', over(true));
  document.addEventListener('dragleave', over(false));
  document.addEventListener('drop', async (event) => {
    over(false)(event);
    try {
      await take(await dropped(event.dataTransfer));
    } catch (error) {
      refuse(error.message);
    }
  });
  for (const id of ['chooser', 'folder']) {
    byId(id).onchange = async ({ target }) => {
      await take([...target.files].filter((file) => id === 'chooser' || isOfDrive(file.name)));
      target.value = '';
    };
  }
  listeners.push(showFiles);
}
