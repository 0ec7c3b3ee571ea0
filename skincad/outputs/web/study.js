// The study's data is that of `page` in study_page.py. A column's head sorts, a row or a point shows its design.
const data = JSON.parse(document.getElementById('data').textContent)
const get = id => document.getElementById(id)
const order = data.rows.map((_, i) => i)
let rising = true, column = 0, chosen = -1

function word(value) {
  if (value === null) return ''
  if (typeof value === 'number') return String(Number(value.toPrecision(5)))
  return value === true ? 'yes' : value === false ? 'no' : value
}

function fillTable() {
  get('rows').replaceChildren(...order.map(i => {
    const row = document.createElement('tr')
    row.className = i === chosen ? 'chosen' : data.refused[i] ? 'refused' : ''
    row.onclick = () => choose(i)
    row.append(...data.rows[i].map(value => {
      const cell = document.createElement('td')
      cell.textContent = word(value)
      if (typeof value === 'string') cell.className = 'text'
      return cell
    }))
    return row
  }))
}

function sortBy(number) {
  rising = number === column ? !rising : true
  column = number
  order.sort((a, b) => {
    const [x, y] = [data.rows[a][number], data.rows[b][number]]
    if (x === y) return a - b
    if (x === null || y === null) return x === null ? 1 : -1  // what a row has not comes last
    return (x < y) === rising ? -1 : 1
  })
  fillTable()
}

function choose(i) {
  chosen = i
  get('which').textContent = 'Row ' + data.rows[i][0]
  get('design').value = data.designs[i]
  fillTable()
  plot()
}

function draw(parent, name, attributes, text = '') {
  const element = document.createElementNS('http://www.w3.org/2000/svg', name)
  for (const key in attributes) element.setAttribute(key, attributes[key])
  element.textContent = text
  parent.append(element)
  return element
}

// Round numbers from a little below the least to a little above the largest value, some five of them.
function ticks(values) {
  const low = Math.min(...values), high = Math.max(...values)
  const wide = (high - low) || Math.abs(low) || 1, size = 10 ** Math.floor(Math.log10(wide / 4))
  const step = size * [1, 2, 5, 10].find(n => n * size >= wide / 5)
  const first = Math.floor((low - 0.02 * wide) / step), last = Math.ceil((high + 0.02 * wide) / step)
  return Array.from({ length: last - first + 1 }, (_, k) => (first + k) * step)
}

// From blue over grey to orange, which the colour-blind tell apart too.
function colourOf(share) {
  const mix = (from, to, part) => from.map((c, k) => Math.round(c + (to[k] - c) * part))
  const [blue, grey, orange] = [[31, 95, 168], [200, 200, 200], [230, 120, 20]]
  return `rgb(${share < 0.5 ? mix(blue, grey, 2 * share) : mix(grey, orange, 2 * share - 1)})`
}

function plot() {
  const picture = get('plot'), [across, up, third] = ['x', 'y', 'colour'].map(axis => +get(axis).value)
  picture.replaceChildren()
  const coloured = third >= 0
  const shown = order.filter(i =>
    [across, up, ...(coloured ? [third] : [])].every(c => typeof data.rows[i][c] === 'number'))
  if (!shown.length) return
  const [u, v] = [across, up].map(c => ticks(shown.map(i => data.rows[i][c])))
  const x = value => 80 + 480 * (value - u[0]) / (u[u.length - 1] - u[0])
  const y = value => 300 - 280 * (value - v[0]) / (v[v.length - 1] - v[0])
  for (const value of u)
    draw(picture, 'text', { x: x(value), y: 316, 'font-size': 10, 'text-anchor': 'middle' }, word(value))
  for (const value of v) {
    draw(picture, 'text', { x: 74, y: y(value) + 3, 'font-size': 10, 'text-anchor': 'end' }, word(value))
    draw(picture, 'line', { x1: 80, x2: 560, y1: y(value), y2: y(value), stroke: '#eee' })
  }
  draw(picture, 'text', { x: 320, y: 338, 'font-size': 11, 'text-anchor': 'middle' }, data.head[across])
  draw(picture, 'text',
    { x: -160, y: 14, 'font-size': 11, 'text-anchor': 'middle', transform: 'rotate(-90)' }, data.head[up])
  const told = coloured ? shown.map(i => data.rows[i][third]) : [0]
  const least = Math.min(...told), most = Math.max(...told)
  for (const i of shown) {
    const share = coloured ? (data.rows[i][third] - least) / ((most - least) || 1) : 0
    const point = draw(picture, 'circle', {
      cx: x(data.rows[i][across]), cy: y(data.rows[i][up]), r: i === chosen ? 7 : 4,
      fill: i === chosen ? '#c24e00' : data.refused[i] ? '#bbb' : colourOf(share), 'fill-opacity': 0.85,
      stroke: i === chosen ? '#222' : 'none',
    })
    draw(point, 'title', {}, 'row ' + data.rows[i][0])
    point.onclick = () => choose(i)
  }
  if (coloured)
    draw(picture, 'text', { x: 560, y: 12, 'font-size': 10, 'text-anchor': 'end' },
      `blue ${word(least)} to orange ${word(most)}`)
}

data.head.forEach((name, number) => {
  const head = document.createElement('th')
  head.textContent = name
  head.onclick = () => sortBy(number)
  get('head').append(head)
  if (!data.rows.some(row => typeof row[number] === 'number')) return
  for (const axis of ['x', 'y', 'colour']) get(axis).append(new Option(name, number))
})
get('colour').prepend(new Option('one for all', -1))
for (const axis of ['x', 'y', 'colour']) {
  get(axis).value = axis === 'colour' ? -1 : data[axis]
  get(axis).onchange = plot
}
get('copy').onclick = () => { get('design').select(); document.execCommand('copy') }
fillTable()
plot()
