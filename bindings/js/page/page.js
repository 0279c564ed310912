// SPDX-License-Identifier: MIT
// Buttons, pointers and dropped files of the page.
'use strict';

const page = (id) => document.getElementById(id);

function fail(error) {
  page('fault').textContent = error.message;
}
/** Shows what work() throws. */
function guarded(work) {
  page('fault').textContent = '';
  try {
    return work();
  } catch (error) {
    fail(error);
    return undefined;
  }
}

async function main() {
  await selvedge.load();
  const stage = new Stage(page('scene')), drape = new Drape(stage), judge = new FrameJudge(stage);
  let judging = false;
  const options = (id, names, chosen) => page(id).append(...names.map((name) => new Option(name, name, name === chosen, name === chosen)));
  options('fabric', kFabrics, 'default');
  options('broad', selvedge.broadPhases(), 'bvh_aabb');
  options('narrow', selvedge.narrowPhases(), 'ccd_exact');

  const restart = () => guarded(() => drape.start());
  for (const id of ['body', 'unit', 'up', 'size', 'particles', 'fabric', 'broad', 'narrow']) page(id).onchange = restart;
  page('restart').onclick = restart;
  page('pause').onclick = () => {
    drape.running = !drape.running;
    if (drape.running) drape.end = Math.max(drape.end, drape.frame + kSeconds * kFps);
  };
  page('judge_now').onclick = () => guarded(() => {
    drape.running = false;
    drape.judge();
  });
  page('contacts').onchange = () => drape.simulation !== null && drape.show();
  page('time').oninput = () => judge.showAt(Number(page('time').value));
  page('example').onclick = () => guarded(() => judge.example());

  const takeBody = (file) => guarded(() => {
    drape.dropped = file;
    page('body').querySelector('[value=dropped]')?.remove();
    page('body').append(new Option(file.name, 'dropped', true, true));
    drape.start();
  });
  const takeFile = async (file, place) => {
    const read = { name: file.name, content: await file.arrayBuffer() };
    if (place === 'drape') takeBody(read);
    else guarded(() => judge.take(place, read));
  };
  page('body_file').onchange = (event) => takeFile(event.target.files[0], 'drape');
  for (const [id, place] of [['frame_0', 0], ['frame_1', 1], ['frame_body', 'body']])
    page(id).onchange = (event) => takeFile(event.target.files[0], place);
  document.ondragover = (event) => {
    event.preventDefault();
    document.body.classList.add('dropping');
  };
  document.ondragleave = () => document.body.classList.remove('dropping');
  document.ondrop = async (event) => {
    event.preventDefault();
    document.body.classList.remove('dropping');
    for (const file of event.dataTransfer.files) await takeFile(file, judging ? judge.nextPlace() : 'drape');
  };

  const choose = (toJudge) => {
    judging = toJudge;
    page('drape').hidden = judging;
    page('judge').hidden = !judging;
    page('tab_drape').setAttribute('aria-selected', String(!judging));
    page('tab_judge').setAttribute('aria-selected', String(judging));
    stage.remove('cloth', 'body', 'crossing', 'pair', 'contacts');
    page('hint').textContent = judging ? 'Drag to turn the view; the wheel or two fingers zoom.' : 'Drag the cloth to pull it. Drag beside it to turn the view; the wheel or two fingers zoom.';
    guarded(() => (judging ? judge.update() : drape.start()));
    if (judging) drape.stop();
  };
  page('tab_drape').onclick = () => choose(false);
  page('tab_judge').onclick = () => choose(true);

  const canvas = page('scene'), pointers = new Map();
  canvas.onpointerdown = (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, event);
    if (pointers.size > 1) drape.drop();
    else if (!judging) drape.grab(stage.ray(event.offsetX, event.offsetY));
  };
  canvas.onpointermove = (event) => {
    const before = pointers.get(event.pointerId);
    if (before === undefined) return;
    const spread = () => {
      const [a, b] = [...pointers.values()];
      return Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY) || 1;
    };
    const wide = pointers.size === 2 ? spread() : 0;
    pointers.set(event.pointerId, event);
    if (drape.pull !== null) drape.drag(stage.ray(event.offsetX, event.offsetY));
    else if (pointers.size === 2) stage.zoom(spread() / wide);
    else stage.turn(event.clientX - before.clientX, event.clientY - before.clientY);
  };
  canvas.onpointerup = canvas.onpointercancel = (event) => {
    pointers.delete(event.pointerId);
    drape.drop();
  };
  canvas.onwheel = (event) => {
    event.preventDefault();
    stage.zoom(Math.exp(-0.001 * event.deltaY));
  };

  guarded(() => drape.start());
  const paint = (now) => {
    try {
      if (!judging) drape.tick(now);
    } catch (error) {
      drape.running = false;
      fail(error);
    }
    stage.draw();
    requestAnimationFrame(paint);
  };
  requestAnimationFrame(paint);
  document.documentElement.dataset.ready = 'yes';
}

main().catch(fail);
