// The drive's machine file: as text, changed and saved.

function showDrive() {
  const text = drive.text.trim();
  const name = /^name\s*=\s*"(.*)"/m.exec(drive.text)?.[1];
  byId('drive').textContent = text ? `${drive.name}${name ? `: ${name}` : ''}` : 'No machine file yet: drop one, or fill in the data sheet.';
  const field = byId('machine');
  // What somebody is typing stays.
  if (field.value !== drive.text && document.activeElement !== field) field.value = drive.text;
  byId('save-machine').disabled = !text;
}

function listenForMachine() {
  byId('machine').onchange = ({ target }) => { drive.text = target.value; check(); };
  byId('save-machine').onclick = () => save(drive.name, 'application/toml', drive.text);
  listeners.push(showDrive);
}
